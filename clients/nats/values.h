#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "clients/nats/link.h"

namespace styled::stylenats {

// Reads the values that StateStore wrote: those of a site in the KV bucket `styled`, and their
// changes. A thread of its own waits for the broker. It only requests values and polls for new
// ones. It creates no consumer, as a watch of libnats would, because a user who may create
// consumers can have the bucket's values sent to any subject of the account. All values are read
// again after every reconnection and every kAgain_s, because a bucket in memory may have restarted
// with smaller numbers.
class Values {
 public:
  static constexpr int kAgain_s = 10;
  // The interval of the polls: 5 small requests a second. A changed body arrives within 24 frames.
  static constexpr int kPoll_ms = 200;
  // A value, or empty if the key was removed. Called on the thread of this object.
  using OnValue = std::function<void(const std::string& key, const std::string* value)>;

  // `domain`: as in StateStore.
  Values(Link& link, const std::string& site, std::string domain, OnValue on_value);
  ~Values();  // waits for a pending answer of the broker, 1 s at most
  Values(const Values&) = delete;
  Values& operator=(const Values&) = delete;

  // The error of the last failed attempt, once; "": none failed since.
  std::string NextError();

 private:
  void Loop(const std::stop_token& stop);
  bool ReadAll(std::uint64_t& next);
  bool Get(const std::vector<std::string>& subjects);
  bool Follow(std::uint64_t next, const std::stop_token& stop);
  std::uint64_t Apply(natsMsg* message);
  bool Fail(natsStatus status);

  Link& link_;
  const std::string filter_, domain_, get_;  // subjects
  const OnValue on_value_;
  std::set<std::string> known_;
  std::mutex mutex_;
  std::string error_, last_error_;
  std::jthread thread_;  // last: it ends before the rest
};

}  // namespace styled::stylenats
