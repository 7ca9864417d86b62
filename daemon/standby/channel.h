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

// The way between two daemons: what this one says, and what the other one says. Messages keep their
// order; those that find a queue full are lost. Pipeline thread; no call blocks.
class Channel {
 public:
  virtual ~Channel() = default;
  virtual void Send(std::span<const std::byte> message) noexcept = 0;
  // The next message of the other daemon; false when there is none.
  virtual bool Receive(std::string& message) = 0;
  // True once after the other daemon began to listen, or asked for everything anew.
  virtual bool TakeAsked() = 0;
  // Asks the other daemon for everything anew: its TakeAsked() becomes true.
  virtual void Ask() = 0;
};

// A Channel over ZeroMQ: an XPUB socket bound at `address`, and a SUB socket connected to `peer`.
// To ask is to subscribe to one more topic. `endpoint` receives the bound address. `fds` receives
// descriptors that are readable when Receive or TakeAsked may find something; edge-triggered.
struct Opened {
  std::unique_ptr<Channel> channel;
  std::string endpoint;
  int publish_fd = -1, subscribe_fd = -1;
};
// `keeper`: both show their keys; null: none.
Result<Opened> OpenZmqChannel(void* context, const config::Standby& config,
                              security::Gatekeeper* keeper = nullptr);

}  // namespace styled::standby
