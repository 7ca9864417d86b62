#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "daemon/runtime/notify.h"
#include "daemon/runtime/wakeup.h"

namespace styled::runtime {

// Feeds the service manager's watchdog from a thread of its own, as long as another thread makes
// progress. That thread increments a number in each turn of its loop; WATCHDOG=1 is sent only when
// the number has changed since the last check. A thread that hangs therefore leads to a restart of
// the process, and long work on any other thread does not. Pinned by
// tests/unit/daemon/runtime/sign_of_life_test.cpp and tests/hostile.
class SignOfLife {
 public:
  // The interval of the checks in milliseconds. The manager and tests see a sign of life at least
  // every second, even if a check finds that the thread has not turned yet.
  static constexpr int kLook_ms = 200;

  // `address`: as in Notifier. `turns` returns the number, `wake` makes an idle thread turn; both
  // are called on this object's thread.
  SignOfLife(const std::string& address, std::function<std::uint64_t()> turns,
             std::function<void()> wake);
  ~SignOfLife();
  SignOfLife(const SignOfLife&) = delete;
  SignOfLife& operator=(const SignOfLife&) = delete;

 private:
  void Run();

  Notifier notifier_;
  std::function<std::uint64_t()> turns_;
  std::function<void()> wake_;
  Wakeup stop_;
  std::thread thread_;
};

// Whether $WATCHDOG_USEC and $WATCHDOG_PID (null when unset) require process `pid` to feed a
// watchdog.
bool WatchdogAsked(const char* usec, const char* watchdog_pid, int pid);

}  // namespace styled::runtime
