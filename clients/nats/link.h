#pragma once

#include <nats/nats.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "clients/nats/link_options.h"
#include "model/base/status.h"

namespace styled::stylenats {

// Deletes libnats' objects, for std::unique_ptr: each of its types has a function of its own.
template <auto kDestroy>
struct Destroys {
  template <typename T>
  void operator()(T* object) const {
    kDestroy(object);
  }
};

// An event of the connection.
struct LinkEvent {
  enum class Kind {
    kAbsent,        // no broker answers; reported once, at the start. text: the TLS error, or ""
    kConnected,     // for the first time; text: the address
    kDisconnected,  // text: why
    kReconnected,   // text: the address
    kClosed,        // the broker refuses us, and libnats gives up; text: why
    kError,         // the broker reports an error, for example of a permission; text: its message
  };
  Kind kind = Kind::kAbsent;
  std::string text;
};

// The connection to the broker, one per process. It connects in the background, and reconnects for
// ever. A broker that answers no ping within 2 s, or that reads nothing for 1 s, counts as gone.
// Nothing is stored for it meanwhile (except one message that is sent at the moment of the loss).
// Other brokers that the broker announces are ignored: frames go only to the named leaf servers.
class Link {
 public:
  // Errors name the option: an address that cannot be parsed, a file that cannot be read. A broker
  // that does not answer is not an error.
  static Result<std::unique_ptr<Link>> Open(const LinkOptions& options);
  ~Link();  // closes; what is not flushed is lost
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  natsConnection* get() const { return connection_; }
  // Any thread. Publish does not show it: it returns NATS_OK while libnats reconnects.
  bool connected() const {
    return natsConnection_Status(connection_) == NATS_CONN_STATUS_CONNECTED;
  }
  // Counts the connections, the first one is 1; 0: none so far. Any thread.
  std::uint64_t generation() const;
  // The events since the last call, at most 64; errors of the same text are one. Any thread.
  std::vector<LinkEvent> Events();
  // A subject of its own for replies to this program, without the last dot.
  std::string NewInbox() const;
  // Waits until the broker has read everything. False: not within `timeout`.
  bool Flush(std::chrono::milliseconds timeout);

 private:
  struct State;
  explicit Link(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
  natsConnection* connection_ = nullptr;
  std::string inbox_prefix_;
};

}  // namespace styled::stylenats
