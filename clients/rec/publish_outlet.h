#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <zmq.hpp>

#include "clients/rec/outlet.h"
#include "sim/player/clock.h"

namespace styled::rec {

struct PublishOutletCounts {
  std::uint64_t messages = 0;
  std::uint64_t dropped = 0;  // no subscriber accepted it within a second
};

// Acts as a daemon's publisher: it republishes the recorded messages, and sends the bodies at once
// to each new subscriber, as WIRE.md requires. At every start and every repetition, frames and
// statistics get a new epoch; otherwise a subscriber that has already seen them would drop them. A
// subscriber that does not read delays this outlet by a second and then loses messages.
class PublishOutlet final : public Outlet {
 public:
  // Binds `endpoint`, e.g. "tcp://127.0.0.1:7001"; port 0 or * is chosen by the system. Errors name
  // the endpoint.
  static Result<std::unique_ptr<PublishOutlet>> Bind(const std::string& endpoint, bool as_recorded);

  void Note(const recording::Record& record) override;
  Status Play(const recording::Record& record) override;
  void Idle() override;
  void Restart() override;

  const std::string& endpoint() const { return endpoint_; }  // as bound
  int subscriptions() const { return subscriptions_; }       // received so far
  const PublishOutletCounts& counts() const { return counts_; }

 private:
  PublishOutlet() = default;
  void Keep(const recording::Published& published);
  void Send(const std::string& topic, const std::string& payload);
  void SendBodies(const std::string& prefix);
  std::string Renewed(const std::string& topic, const std::string& payload) const;

  zmq::context_t context_{1};
  zmq::socket_t socket_;
  std::string endpoint_;
  bool as_recorded_ = false;
  std::uint64_t salt_ = 0;
  int subscriptions_ = 0;
  bool announce_ = false;  // some recorded bodies have not been sent yet
  std::map<std::pair<std::string, int>, std::string> bodies_;  // by topic and output: payload
  PublishOutletCounts counts_;
};

}  // namespace styled::rec
