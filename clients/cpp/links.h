#pragma once

#include <chrono>
#include <string>
#include <vector>
#include <zmq.hpp>

namespace styled::client {

// The connections of one SUB socket to its endpoints: counts the live ones, and reconnects the dead
// ones. libzmq reconnects by itself to an address where no program listens, but gives up a peer
// that breaks the protocol, although a daemon may start there later. One thread, the socket's.
class Links {
 public:
  // Call before the socket connects. Throws zmq::error_t.
  void Watch(zmq::context_t& context, zmq::socket_t& socket, std::vector<std::string> endpoints);
  // Endpoints with a live connection.
  int Count();
  // Call while nothing arrives. With several endpoints the live ones stay as they are. Endpoints
  // with host names, which libzmq's events do not identify, are only reconnected while none is
  // live. Throws zmq::error_t.
  void RenewDead();

  static constexpr std::chrono::milliseconds kLook{500};    // interval of RenewDead
  static constexpr std::chrono::milliseconds kRenew{2000};  // libzmq gets this long to connect

 private:
  using Clock = std::chrono::steady_clock;
  void ReadEvents();

  zmq::socket_t* socket_ = nullptr;
  zmq::socket_t monitor_;
  std::vector<std::string> endpoints_;
  std::vector<std::string> live_;  // addresses as libzmq writes them
  Clock::time_point renewed_ = Clock::now(), looked_ = renewed_;
};

}  // namespace styled::client
