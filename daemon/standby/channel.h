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

// The largest message. Checkpoints are 64 KiB and more, a made style or a request up to some MiB. A
// reader cuts the connection on which a larger one comes, and could not tell that from a leader
// that is gone: so no daemon sends one.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{16} << 20U;

// The way between two daemons: what this one says, and what the other one says. Messages keep their
// order; those that find a queue full are lost. Pipeline thread; no call blocks.
class Channel {
 public:
  enum class Subscription : std::uint8_t { kNone, kBegan, kEnded };

  virtual ~Channel() = default;
  // At most max_bytes() at once.
  virtual void Send(std::span<const std::byte> message) noexcept = 0;
  virtual std::size_t max_bytes() const { return kMaxMessageBytes; }
  // The next message from the other daemon's address; false when there is none. It may come from
  // any program there.
  virtual bool Receive(std::string& message) = 0;
  // The next of the subscriptions to this daemon's messages. One begins when the other daemon
  // connects, and when it asks for everything anew; anybody else may subscribe, too.
  virtual Subscription NextSubscription() = 0;
  // Asks the other daemon for everything anew: a subscription begins there.
  virtual void Ask() = 0;
  // Connects to the other daemon's address anew. Call it while nothing is heard from there: another
  // program that answered in its place may have ended the connection for good.
  virtual void Reconnect() {}
};

// A Channel over ZeroMQ: an XPUB socket bound at `address`, and a SUB socket connected to `peer`.
// To ask is to subscribe to one more topic. `endpoint` receives the bound address. `fds` receives
// descriptors that are readable when Receive or NextSubscription may find something;
// edge-triggered.
struct Opened {
  std::unique_ptr<Channel> channel;
  std::string endpoint;
  int publish_fd = -1, subscribe_fd = -1;
};
// `keeper`: both show their keys; null: none.
Result<Opened> OpenZmqChannel(void* context, const config::Standby& config,
                              security::Gatekeeper* keeper = nullptr);

}  // namespace styled::standby
