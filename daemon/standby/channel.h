#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "daemon/config/config.h"
#include "daemon/security/gatekeeper.h"
#include "model/base/status.h"

namespace styled::standby {

// The largest message. Checkpoints have 64 KiB and more, a made style or a request up to some MiB.
// A reader closes the connection on a larger message and cannot distinguish that from a dead
// leader, so no daemon sends one.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{16} << 20U;

// The connection between the two daemons of a pair, in both directions. Messages keep their order;
// a message that finds a queue full is lost. Pipeline thread; no call blocks.
class Channel {
 public:
  enum class Subscription : std::uint8_t { kNone, kBegan, kEnded };

  virtual ~Channel() = default;
  // Sends a message of at most max_bytes().
  virtual void Send(std::span<const std::byte> message) noexcept = 0;
  virtual std::size_t max_bytes() const { return kMaxMessageBytes; }
  // The next message from the peer's address; false when there is none. Any program at that address
  // may have sent it.
  virtual bool Receive(std::string& message) = 0;
  // The next change of the subscriptions to this daemon's messages. One begins when the peer
  // connects and when it requests the whole state. Other programs may subscribe, too.
  virtual Subscription NextSubscription() = 0;
  // Requests the whole state: a subscription begins at the peer.
  virtual void Ask() = 0;
  // Connects again. Call it while the peer is silent: another program at its address may have ended
  // the connection permanently.
  virtual void Reconnect() {}
};

// A Channel over ZeroMQ: an XPUB socket bound at `address` and a SUB socket connected to `peer`.
// Ask subscribes to one more topic. `endpoint` is the bound address. The descriptors are readable,
// edge-triggered, when NextSubscription or Receive may return something.
struct Opened {
  std::unique_ptr<Channel> channel;
  std::string endpoint;
  int publish_fd = -1, subscribe_fd = -1;
};
// `keeper`: both daemons authenticate by their keys; null: no authentication.
Result<Opened> OpenZmqChannel(void* context, const config::Standby& config,
                              security::Gatekeeper* keeper = nullptr);

}  // namespace styled::standby
