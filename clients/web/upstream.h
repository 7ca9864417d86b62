#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <zmq.hpp>

#include "clients/cpp/curve.h"
#include "model/base/status.h"

namespace styled::web {

// The gateway's only subscription socket, integrated into the loop of `io` through ZMQ_FD. It
// subscribes to the requested topics and passes messages on unchanged. Connects in the background
// and reconnects by itself.
//
// The loop's thread only. Allocates.
class Upstream {
 public:
  struct Handlers {
    std::function<void(std::string_view topic, std::string_view payload)> message;
    std::function<void()> disconnected;  // the connection was lost
  };

  // Refuses an endpoint that ZeroMQ cannot parse, and invalid keys. It is not an error if no daemon
  // listens there yet.
  static Result<std::unique_ptr<Upstream>> Connect(boost::asio::io_context& io,
                                                   const std::string& endpoint,
                                                   const std::optional<client::Curve>& curve,
                                                   Handlers handlers);
  ~Upstream();
  Upstream(const Upstream&) = delete;
  Upstream& operator=(const Upstream&) = delete;

  // Subscribe at most once per topic; Unsubscribe only what was subscribed.
  void Subscribe(const std::string& topic);
  void Unsubscribe(const std::string& topic);
  std::size_t topics() const { return topics_; }          // subscribed to
  std::uint64_t malformed() const { return malformed_; }  // messages not of two parts

 private:
  Upstream(boost::asio::io_context& io, Handlers handlers);
  void Open(const std::string& endpoint, const std::optional<client::Curve>& curve);
  void Wait(boost::asio::posix::stream_descriptor& descriptor);
  void Soon();
  void Drain();
  bool ReadMessage();
  void ReadEvents();

  boost::asio::io_context& io_;
  Handlers handlers_;
  zmq::context_t context_{1};
  zmq::socket_t socket_, monitor_;
  boost::asio::posix::stream_descriptor readable_, events_;
  zmq::message_t topic_, payload_;
  std::size_t topics_ = 0;
  std::uint64_t malformed_ = 0;
  bool drain_posted_ = false;
  // Reset by the destructor: callbacks still queued then do nothing.
  std::shared_ptr<Upstream*> self_;
};

}  // namespace styled::web
