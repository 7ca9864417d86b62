#include "clients/cpp/links.h"

#include <zmq.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <utility>

namespace styled::client {
namespace {

// Whether an endpoint's host is a name, not numbers.
bool HasHostName(std::string_view endpoint) {
  constexpr std::string_view kTcp = "tcp://";
  if (!endpoint.starts_with(kTcp)) return false;
  endpoint.remove_prefix(kTcp.size());
  return !endpoint.starts_with('[') &&
         endpoint.find_first_not_of("0123456789.:") != std::string_view::npos;
}

}  // namespace

void Links::Watch(zmq::context_t& context, zmq::socket_t& socket,
                  std::vector<std::string> endpoints) {
  socket_ = &socket;
  endpoints_ = std::move(endpoints);
  std::array<char, 64> name{};
  std::snprintf(name.data(), name.size(), "inproc://monitor-%p", static_cast<void*>(this));
  if (zmq_socket_monitor(socket.handle(), name.data(),
                         ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED) != 0) {
    throw zmq::error_t();
  }
  monitor_ = zmq::socket_t(context, zmq::socket_type::pair);
  monitor_.set(zmq::sockopt::linger, 0);
  monitor_.connect(name.data());
}

void Links::ReadEvents() {
  zmq::message_t event, address;
  while (monitor_.recv(event, zmq::recv_flags::dontwait)) {
    if (!event.more() || !monitor_.recv(address, zmq::recv_flags::none)) break;
    if (event.size() < 2) continue;
    std::uint16_t number = 0;
    std::copy_n(static_cast<const char*>(event.data()), 2, reinterpret_cast<char*>(&number));
    const std::string place = address.to_string();
    const auto known = std::ranges::find(live_, place);
    if (number == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
      live_.push_back(place);
    } else if (known != live_.end()) {  // a failed handshake also ends in a disconnection
      live_.erase(known);
    }
  }
}

int Links::Count() {
  try {
    ReadEvents();
  } catch (const zmq::error_t&) {
    // The former state is used.
  }
  return static_cast<int>(live_.size());
}

void Links::RenewDead() {
  const auto now = Clock::now();
  if (now - looked_ < kLook) return;
  looked_ = now;
  ReadEvents();
  if (live_.size() >= endpoints_.size()) renewed_ = now;
  if (now - renewed_ < kRenew) return;
  renewed_ = now;
  for (const std::string& endpoint : endpoints_) {
    if (std::ranges::count(live_, endpoint) > 0) continue;
    if (HasHostName(endpoint) && !live_.empty()) continue;
    try {
      socket_->disconnect(endpoint);
    } catch (const zmq::error_t&) {
      // libzmq has already dropped it.
    }
    socket_->connect(endpoint);
  }
}

}  // namespace styled::client
