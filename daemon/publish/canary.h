#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string_view>

#include "daemon/runtime/counters.h"
#include "daemon/runtime/zmq_socket.h"
#include "model/base/realtime.h"
#include "model/base/status.h"

namespace styled::publish {

// A subscriber inside the daemon that promptly reads everything published on "styled/", "source/"
// and "stats/". Its queue holds twice high_water_mark: the queue of any subscriber, and as much
// again for the buffers of a connection. A message that it misses is missed by every subscriber of
// the same topics: either the process had no time to empty its queues, or more was published at
// once than they hold. It does not detect subscribers that miss messages because they are slow
// themselves. Its subscription does not make the pipeline publish a topic.
class Canary {
 public:
  // Connects to `publisher`, an XPUB socket with ZMQ_SNDHWM `high_water_mark` that is not bound yet
  // and has no subscriber yet. Must not outlive its context.
  static Result<std::unique_ptr<Canary>> Open(void* context, runtime::ZmqSocket& publisher,
                                              int high_water_mark);

  // Publisher's thread, after a message was sent.
  STYLED_REALTIME void NoteSent(std::string_view topic) noexcept {
    if (!topic.starts_with(kPrefix)) return;
    sent_.store(sent_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  // The reader's thread: reads the waiting messages and counts both them and the missing ones.
  // Returns how many were read. Allocates nothing.
  std::uint64_t Drain(runtime::Counters& counters) noexcept;
  void* socket() const { return socket_.get(); }

 private:
  // A prefix to which no client subscribes: libzmq reports only the last unsubscription of a
  // prefix.
  static constexpr std::string_view kPrefix = "s";

  explicit Canary(runtime::ZmqSocket socket) : socket_(std::move(socket)) {}

  runtime::ZmqSocket socket_;
  std::atomic<std::uint64_t> sent_{0};
  std::uint64_t received_ = 0, missed_ = 0;
};

}  // namespace styled::publish
