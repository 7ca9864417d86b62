#pragma once

#include <nats/nats.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "clients/nats/link.h"

namespace styled::stylenats {

// Writes the data that a late joiner needs into the KV bucket `styled`: bodies, and performers with
// their style. A missing bucket is created, in memory. This is retried until it succeeds (a
// starting cluster has no leader at first), after every reconnection, and when the bucket is gone
// or lacks values (checked every 2 s). All values are then written again.
//
// A thread of its own: each write waits for the broker's answer, up to a second, and no frame may
// wait for that.
//
// Bounded: kMaxKeys keys, kMaxBytes of values; values beyond that are refused and counted. Any
// thread.
class StateStore {
 public:
  static constexpr std::size_t kMaxKeys = 4096;
  static constexpr std::size_t kMaxBytes = std::size_t{32} << 20U;

  // Totals since the start.
  struct Counts {
    std::atomic<std::uint64_t> written{0};
    std::atomic<std::uint64_t> failed{0};   // attempts; each is retried
    std::atomic<std::uint64_t> refused{0};  // beyond the bounds
  };

  // `domain`: of the JetStream that has the bucket; "": the account's own.
  StateStore(Link& link, std::string domain);
  ~StateStore();
  StateStore(const StateStore&) = delete;
  StateStore& operator=(const StateStore&) = delete;

  // Nothing happens if the key has this value already.
  void Put(const std::string& key, std::string_view value);
  void Remove(const std::string& key);
  // Ends the thread: at once, or after the current request (1 s at most).
  void Stop();

  const Counts& counts() const { return counts_; }
  void RequestStop() { thread_.request_stop(); }
  // The error of the last failed attempt, once; "": none failed since.
  std::string NextError();

 private:
  struct Entry {
    std::string value;
    bool removed = false;
    bool waits = false;         // in `order_`
    std::uint64_t version = 0;  // of `value`, to see whether it changed during a write
  };
  using Clock = std::chrono::steady_clock;
  void Loop(const std::stop_token& stop);
  bool Step();
  bool Holds();
  bool Bind();
  void Unbind();
  void Queue(const std::string& key, Entry& entry);
  bool WriteNext();
  void Fail(const std::string& what);

  Link& link_;
  const std::string domain_;
  Counts counts_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::map<std::string, Entry, std::less<>> entries_;
  std::deque<std::string> order_;
  std::size_t bytes_ = 0;
  std::string error_, last_error_;
  std::uint64_t generation_ = 0;  // of the connection that the bucket was bound on
  Clock::time_point next_check_;
  jsCtx* jetstream_ = nullptr;
  kvStore* bucket_ = nullptr;
  std::jthread thread_;
};

}  // namespace styled::stylenats
