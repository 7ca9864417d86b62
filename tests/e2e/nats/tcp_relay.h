#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

namespace styled::support {

// A link between two programs of this machine that can be slow, silent or closed: what connects to
// `port` of loopback is passed on to the port `to`, and back, in order.
//
// While it is silent no byte passes and neither end is notified, as when a cable is pulled: bytes
// sent meanwhile wait in the kernel's buffers and arrive when the link is up again, if the
// connection still exists. While it is closed, connections break and new ones are refused.
class TcpRelay {
 public:
  enum class State { kUp, kSilent, kClosed };
  explicit TcpRelay(const std::string& to, std::chrono::milliseconds delay_each_way = {});
  ~TcpRelay();
  TcpRelay(const TcpRelay&) = delete;
  TcpRelay& operator=(const TcpRelay&) = delete;

  void Set(State state) { state_ = state; }
  int connections() const { return connections_; }  // so far
  std::string port;

 private:
  void Run(const std::stop_token& stop);
  const std::string to_;
  const std::chrono::milliseconds delay_;
  int listener_;
  std::atomic<State> state_{State::kUp};
  std::atomic<int> connections_{0};
  std::jthread thread_;
};

}  // namespace styled::support
