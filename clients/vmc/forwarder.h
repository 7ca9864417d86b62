#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/subscriber.h"
#include "clients/vmc/pace.h"
#include "clients/vmc/puppet.h"
#include "clients/vmc/target.h"

namespace styled::stylevmc {

struct Options {
  std::vector<std::string> publishers = {std::string(client::kDefaultPublisher)};
  std::optional<client::Curve> curve;  // for publishers that ask for keys
  std::string performer;               // of the targets that name none; "" = the first that is seen
  std::vector<TargetSpec> targets;     // at least one
  double rate_hz = 120;                // cap, for each performer
  Carrier carrier = Carrier::kHips;
  // Where no performer is named: how long the one who is shown may be silent before another is.
  std::chrono::nanoseconds patience = std::chrono::seconds(5);
};

// Since Open. Nothing is ever reset.
struct Counts {
  std::uint64_t frames = 0;    // sent
  std::uint64_t thinned = 0;   // left out: above the rate, or superseded before they were read
  std::uint64_t missed = 0;    // lost between daemon and here
  std::uint64_t bodiless = 0;  // left out: their body has not arrived
  std::uint64_t failed = 0;    // datagrams that the system refused, over all targets
  std::string last_error;      // of a datagram or a body; "" = none since it was last asked for
};

// The targets that are shown one performer.
struct Channel {
  std::string wanted;   // "" = whoever is first
  std::string current;  // who is shown; "" = nobody yet
  std::vector<std::unique_ptr<Target>> targets;
  Counts counts;

  Puppet puppet;
  RateCap cap;
  Timeline timeline;
  std::shared_ptr<const v1::Body> body;  // the one that `puppet` is bound to
  bool usable = false;                   // ... and it could be
  std::int64_t last_ns = 0;              // when a frame of `current` came
};

// A subscriber of the daemon that sends every styled frame, at once, to its targets as VMC. Where a
// target names no performer, and none is named for all, it is shown the first one that moves, and
// another once that one was silent for Options::patience. One thread.
// Pinned by tests/unit/vmc_out/forwarder_test.cpp and tests/e2e/vmc_out.
class Forwarder {
 public:
  // Errors: a host that cannot be looked up, an endpoint that ZeroMQ cannot parse.
  static Result<std::unique_ptr<Forwarder>> Open(const Options& options);

  // Waits up to `timeout` for frames and forwards the newest of each performer.
  void Step(std::chrono::milliseconds timeout);

  int connected() { return subscriber_->connected(); }
  std::vector<Channel>& channels() { return channels_; }

 private:
  Forwarder() = default;
  Status OpenTargets(const Options& options);
  void Forward(const client::Update& update, Channel& channel, std::int64_t now_ns);
  void Send(const vmc::Packed& packed, Channel& channel);

  std::unique_ptr<client::Subscriber> subscriber_;
  std::chrono::nanoseconds patience_{};
  std::vector<Channel> channels_;
  std::vector<client::Update> updates_;
  std::array<std::byte, vmc::Packer::kMaxPacketSize> buffer_{};
};

}  // namespace styled::stylevmc
