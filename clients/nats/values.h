#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>

#include "clients/nats/link.h"

namespace styled::stylenats {

// Reads what StateStore wrote: the values of a site in the KV bucket `styled`, and how they change.
// A thread of its own waits for the broker. The bucket is watched anew after every reconnection and
// every kAgain_s: a broker that was started again behind a leaf server has forgotten the watch, and
// says nothing.
class Values {
 public:
  static constexpr int kAgain_s = 10;
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
  bool Watch(const std::stop_token& stop);
  bool Read(kvWatcher* watcher, const std::stop_token& stop);
  void Fail(natsStatus status);

  Link& link_;
  const std::string keys_, domain_;
  const OnValue on_value_;
  std::set<std::string> known_;
  std::mutex mutex_;
  std::string error_, last_error_;
  std::jthread thread_;  // last: it ends before the rest
};

}  // namespace styled::stylenats
