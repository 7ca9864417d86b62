#pragma once

#include <chrono>
#include <string>
#include <vector>
#include <zmq.hpp>

namespace styled::client {

// The connections of one SUB socket to its endpoints: counts those that are live, and makes anew
// those that are dead. libzmq connects again by itself to an address where nobody listens, but
// gives up one that breaks the protocol, although a daemon may come there later. One thread, the
// socket's.
class Links {
 public:
  // Call before the socket connects. Throws zmq::error_t.
  void Watch(zmq::context_t& context, zmq::socket_t& socket, std::vector<std::string> endpoints);
  // Endpoints with a live connection.
  int Count();
  // Call while nothing arrives. Of several endpoints those that are live stay as they are; of
  // names, which libzmq's events do not tell, none is made anew while another is live. Throws
  // zmq::error_t.
  void RenewDead();

  static constexpr std::chrono::milliseconds kLook{500};    // how often RenewDead looks
  static constexpr std::chrono::milliseconds kRenew{2000};  // so long one waits for libzmq

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
