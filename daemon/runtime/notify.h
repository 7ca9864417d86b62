#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "model/base/descriptor.h"

namespace styled::runtime {

// Reports the daemon's state to the service manager with the datagrams of sd_notify(3), which are
// simple enough to need no library. Without a manager, or where its socket cannot be reached, every
// call does nothing. A line break would end a message, so line breaks in `text` become spaces. One
// thread.
class Notifier {
 public:
  // `address` has the form of $NOTIFY_SOCKET: a path, or '@' and an abstract name. "" means that
  // there is no manager.
  explicit Notifier(const std::string& address);
  static Notifier FromEnvironment();

  void Ready(std::string_view text);
  // Call Ready() afterwards, whether the reload succeeded or not.
  void Reloading(std::int64_t now_ns);  // CLOCK_MONOTONIC
  void Stopping();
  void Say(std::string_view text);  // sets the status line of `systemctl status`
  void Alive();                     // feeds the manager's watchdog

 private:
  // Periodic messages are sent with MSG_DONTWAIT and dropped when the manager is behind. All others
  // wait for at most a second.
  void Send(const std::string& message, int flags = 0);

  std::string address_;
  Descriptor socket_;
};

// Feeds the manager's watchdog on behalf of another thread. That thread increments a number each
// time its loop turns; the watchdog is fed only when the number has changed since the last call of
// Look(). A hung thread therefore leads to a restart of the process even when the caller of Look()
// is well.
class Watchdog {
 public:
  // `asked`: the manager has a watchdog. `notifier` must outlive this object.
  Watchdog(Notifier& notifier, bool asked) : notifier_(notifier), asked_(asked) {}
  bool asked() const { return asked_; }
  void Look(std::uint64_t turns);

 private:
  Notifier& notifier_;
  bool asked_;
  std::uint64_t seen_ = 0;
};

// Whether $WATCHDOG_USEC and $WATCHDOG_PID (null when unset) require process `pid` to feed a
// watchdog.
bool WatchdogAsked(const char* usec, const char* watchdog_pid, int pid);

}  // namespace styled::runtime
