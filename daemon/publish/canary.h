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

// A subscriber inside the daemon that reads in good time whatever is published on "styled/",
// "source/" and "stats/". Its queue holds twice high_water_mark: one is any subscriber's, and as
// much lies in the buffers of a connection. What it misses, every subscriber of as much has missed:
// the process had no time to empty its queues, or more was published at once than they hold. What
// another one misses because it is slow itself is not seen here. Its subscription does not make the
// pipeline publish a topic.
class Canary {
 public:
  // Connects to `publisher`, an XPUB socket with ZMQ_SNDHWM `high_water_mark` that is not bound yet
  // and whose first subscriber this is. Must not outlive its context.
  static Result<std::unique_ptr<Canary>> Open(void* context, runtime::ZmqSocket& publisher,
                                              int high_water_mark);

  // Publisher's thread, after a message was sent.
  STYLED_REALTIME void NoteSent(std::string_view topic) noexcept {
    if (!topic.starts_with(kPrefix)) return;
    sent_.store(sent_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  // The reader's thread: reads what has come and counts it, and what is missing. Returns how many
  // messages were read. Allocates nothing.
  std::uint64_t Drain(runtime::Counters& counters) noexcept;
  void* socket() const { return socket_.get(); }

 private:
  // No client subscribes to just this: libzmq reports only the last unsubscription of a prefix.
  static constexpr std::string_view kPrefix = "s";

  explicit Canary(runtime::ZmqSocket socket) : socket_(std::move(socket)) {}

  runtime::ZmqSocket socket_;
  std::atomic<std::uint64_t> sent_{0};
  std::uint64_t received_ = 0, missed_ = 0;
};

}  // namespace styled::publish
