#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/runtime/descriptor.h"

namespace styled::runtime {

// Tells the service manager how it goes: sd_notify(3)'s datagrams, which are so little that a
// library for them would be more. Without a manager, or where its socket cannot be reached, all of
// it does nothing. Lines break messages apart: those of `text` become spaces. One thread.
class Notifier {
 public:
  // `address` as in $NOTIFY_SOCKET: a path, or @ and an abstract name; "" = no manager.
  explicit Notifier(const std::string& address);
  static Notifier FromEnvironment();

  void Ready(std::string_view text);
  // Ready() follows, whether the reload was a success or not.
  void Reloading(std::int64_t now_ns);  // CLOCK_MONOTONIC
  void Stopping();
  void Say(std::string_view text);  // the status line of `systemctl status`
  void Alive();                     // to the manager's watchdog

 private:
  // Where the manager is behind, what is said again and again is dropped (MSG_DONTWAIT), the rest
  // waits for a second at most.
  void Send(const std::string& message, int flags = 0);

  std::string address_;
  Descriptor socket_;
};

// Passes on that a thread lives, by a number that the thread counts up as it turns. The manager's
// watchdog is fed only when that number moved since the last look, so that a hung thread has the
// process restarted although the one that looks is well.
class Watchdog {
 public:
  // `asked`: the manager has a watchdog. All of it outlives this.
  Watchdog(Notifier& notifier, bool asked) : notifier_(notifier), asked_(asked) {}
  bool asked() const { return asked_; }
  void Look(std::uint64_t turns);

 private:
  Notifier& notifier_;
  bool asked_;
  std::uint64_t seen_ = 0;
};

// Whether $WATCHDOG_USEC and $WATCHDOG_PID (null: unset) ask process `pid` to feed a watchdog.
bool WatchdogAsked(const char* usec, const char* watchdog_pid, int pid);

}  // namespace styled::runtime
