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
#include "clients/vmc/vrchat_feed.h"

namespace styled::stylevmc {

struct Options {
  std::vector<std::string> publishers = {std::string(client::kDefaultPublisher)};
  std::optional<client::Curve> curve;  // for publishers that require keys
  std::string performer;               // for targets that name none; "" = the first one seen
  std::vector<TargetSpec> targets;     // at least one
  double rate_hz = 120;                // maximum, per performer
  Carrier carrier = Carrier::kHips;
  std::optional<VrChatFeed::Options> vrchat;  // OSC trackers for VRChat instead of VMC
  // For targets without a named performer: the current one is replaced by another after this time
  // without frames.
  std::chrono::nanoseconds patience = std::chrono::seconds(5);
};

// Totals since Open; never reset.
struct Counts {
  std::uint64_t frames = 0;    // sent
  std::uint64_t thinned = 0;   // skipped: above rate_hz, or superseded before they were read
  std::uint64_t missed = 0;    // lost between daemon and this program
  std::uint64_t bodiless = 0;  // skipped: their body has not arrived
  std::uint64_t failed = 0;    // datagrams that the system refused, summed over targets
  std::string last_error;      // of a datagram or a body; "" = none since it was last read
};

// The targets that receive the same performer.
struct Channel {
  std::string wanted;   // "" = the first one seen
  std::string current;  // the performer being forwarded; "" = none yet
  std::vector<std::unique_ptr<Target>> targets;
  Counts counts;

  Puppet puppet;
  std::optional<VrChatFeed> vrchat;  // used instead of `puppet`
  RateCap cap;
  Timeline timeline;
  std::shared_ptr<const v1::Body> body;  // the body that `puppet` is bound to
  bool usable = false;                   // binding `body` succeeded
  std::int64_t last_ns = 0;              // arrival of the last frame of `current`
};

// Subscribes to the daemon and sends every styled frame immediately to its targets as VMC. A target
// without a named performer (nor one named for all targets) receives the first performer that
// moves. After that performer was silent for Options::patience, the target switches to another one.
// One thread. Pinned by tests/unit/vmc_out/forwarder_test.cpp and tests/e2e/vmc_out.
class Forwarder {
 public:
  // Errors: a host that does not resolve, an endpoint that ZeroMQ cannot parse.
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
  static void Send(std::span<const std::byte> datagram, Channel& channel);

  std::unique_ptr<client::Subscriber> subscriber_;
  std::chrono::nanoseconds patience_{};
  std::vector<Channel> channels_;
  std::vector<client::Update> updates_;
  std::array<std::byte, vmc::Packer::kMaxPacketSize> buffer_{};
};

}  // namespace styled::stylevmc
