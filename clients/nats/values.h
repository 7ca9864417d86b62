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

// Reads what StateStore wrote: the values of a site in the KV bucket `styled`, and how they change.
// A thread of its own waits for the broker. It only asks for values, and asks whether there are new
// ones; it makes no consumer, as a watch of libnats would: who may make consumers can have the
// bucket's values sent to any subject of the account. All values are read after every reconnection
// and every kAgain_s: a bucket in memory may have begun anew, with smaller numbers.
class Values {
 public:
  static constexpr int kAgain_s = 10;
  // Between two questions for what is new: 5 small ones a second. A body that changes is here
  // before anybody sees more than 24 frames that have none.
  static constexpr int kPoll_ms = 200;
  // A value, or nothing where the key was removed. Called on the thread of this object.
  using OnValue = std::function<void(const std::string& key, const std::string* value)>;

  // `domain`: as in StateStore.
  Values(Link& link, const std::string& site, std::string domain, OnValue on_value);
  ~Values();  // waits for the broker's answer that is due, 1 s at most
  Values(const Values&) = delete;
  Values& operator=(const Values&) = delete;

  // What the last failed attempt said, once; "": none failed since.
  std::string TakeError();

 private:
  void Loop(const std::stop_token& stop);
  bool ReadAll(std::uint64_t& next);
  bool Get(const std::vector<std::string>& subjects);
  bool Follow(std::uint64_t next, const std::stop_token& stop);
  std::uint64_t Take(natsMsg* message);
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
