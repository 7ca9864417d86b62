#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "daemon/runtime/counters.h"

namespace styled::publish {

// A topic that can be published on. `wanted` is the number of distinct subscriptions that match it;
// while it is 0 nothing is serialized. Each matching subscription, even a repeated one, sets
// `asked`; the code that answers with the body clears it.
struct Topic {
  std::string name;  // ends in "/"
  int wanted = 0;
  bool asked = false;
  // Shorter prefixes do not ask for it: a client that subscribes to everything does not mean this
  // topic.
  std::size_t least_prefix = 0;
};

// The active subscriptions, matched as ZeroMQ does: a subscription is a prefix. Bounded: at most
// `max_subscriptions` distinct ones, and none that cannot match a published topic. (libzmq keeps an
// unbounded set of its own; this bounds the daemon's work and memory.) Pipeline thread only;
// allocates.
class Subscriptions {
 public:
  Subscriptions(int max_subscriptions, runtime::Counters& counters)
      : max_(static_cast<std::size_t>(max_subscriptions)), counters_(counters) {
    for (Topic& topic : bundles_) Register(topic);
  }
  Subscriptions(const Subscriptions&) = delete;
  Subscriptions& operator=(const Subscriptions&) = delete;

  // The topic must outlive its registration; its counts are set at once.
  void Register(Topic& topic);
  void Unregister(Topic& topic);

  // The topics of the bundles, which exist even without a performer. Only a prefix that begins with
  // "frames/" asks for them.
  enum BundleIndex : std::uint8_t { kRigBundle, kCanonicalBundle, kSourceBundle, kBundleCount };
  const Topic& bundle(std::size_t index) const { return bundles_[index]; }

  // With XPUB_VERBOSE, libzmq reports every subscription, but only the last unsubscription of a
  // topic.
  void Subscribe(std::string_view prefix);
  void Unsubscribe(std::string_view prefix);

 private:
  std::size_t max_;
  runtime::Counters& counters_;
  std::unordered_set<std::string> active_;
  std::vector<Topic*> topics_;
  static constexpr std::size_t kBundlePrefix = std::string_view("frames/").size();
  std::array<Topic, kBundleCount> bundles_{
      Topic{.name = "frames/rig/", .least_prefix = kBundlePrefix},
      Topic{.name = "frames/canonical/", .least_prefix = kBundlePrefix},
      Topic{.name = "frames/source/", .least_prefix = kBundlePrefix}};
};

}  // namespace styled::publish
