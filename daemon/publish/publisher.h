#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "daemon/config/config.h"
#include "daemon/runtime/counters.h"
#include "daemon/security/gatekeeper.h"
#include "model/base/status.h"

namespace styled::publish {

struct SubscriptionEvent {
  bool subscribe = false;
  std::string topic;
};

// Publishes messages of two parts, topic and payload. Pipeline thread only.
class Publisher {
 public:
  virtual ~Publisher() = default;
  // Sends at once or drops, never blocks. `payload` may be reused on return.
  virtual void Send(std::string_view topic, std::span<const std::byte> payload) noexcept = 0;
  // Announces that so many messages are about to be sent at once: from now on each subscriber's
  // queue holds as many more than usual. It may allocate.
  virtual void MakeRoom(std::size_t /*messages*/) {}
  // The next change of subscriptions; false when there is none.
  virtual bool NextSubscription(SubscriptionEvent& event) = 0;
  // Edge-triggered: call NextSubscription until it returns false before waiting on it. -1: none.
  virtual int fd() const = 0;
};

// Opens the XPUB socket. `context` is the process' ZeroMQ context. A subscriber that does not read
// loses frames at its own queue (high_water_mark), without effect on others. `keeper` admits only
// clients with keys; null admits every client that can reach the address. `endpoint` receives the
// bound address.
Result<std::unique_ptr<Publisher>> MakeZmqPublisher(void* context, const config::Publish& config,
                                                    runtime::Counters& counters,
                                                    std::string& endpoint,
                                                    security::Gatekeeper* keeper = nullptr);

}  // namespace styled::publish
