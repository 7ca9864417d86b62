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
  void SetStatus(std::string_view text);  // sets the status line of `systemctl status`
  void Alive();                           // feeds the manager's watchdog

 private:
  // Periodic messages are sent with MSG_DONTWAIT and dropped when the manager is behind. All others
  // wait for at most a second.
  void Send(const std::string& message, int flags = 0);

  std::string address_;
  Descriptor socket_;
};

}  // namespace styled::runtime
