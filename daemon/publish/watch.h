#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "daemon/publish/canary.h"
#include "daemon/publish/stalled.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"
#include "daemon/runtime/wakeup.h"

namespace styled::publish {

// The thread that detects lost messages of subscribers: it reads the canary, and checks once a
// second for subscribers that have stopped reading. It writes counters and, for stalled
// subscribers, the log.
class Watch {
 public:
  // `canary` may be null. `endpoint`: the publisher's, as bound.
  Watch(std::unique_ptr<Canary> canary, int high_water_mark, const std::string& endpoint,
        runtime::Counters& counters);
  ~Watch();  // ends the thread
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  Canary* canary() const { return canary_.get(); }

 private:
  void Run();
  void Wait(std::int64_t wait_ns);
  void ReadCanary();
  void CheckStalled();

  std::unique_ptr<Canary> canary_;
  std::int64_t high_water_mark_;
  runtime::SystemClock clock_;
  std::int64_t read_ns_ = 0;    // time of the canary's last reading
  std::int64_t period_ns_ = 0;  // time until its next reading; 0: when a message arrives
  StalledSubscribers stalled_;
  runtime::Counters& counters_;
  runtime::Wakeup wake_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace styled::publish
