#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "daemon/runtime/counters.h"

namespace styled::publish {

// A topic that something could be published on. `wanted` counts the distinct subscriptions that
// match it: nothing is serialized while it is 0. `asked` is set by each matching subscription, a
// repeated one too, and cleared by whoever answers it with the body.
struct Topic {
  std::string name;  // ends in "/"
  int wanted = 0;
  bool asked = false;
};

// Which topics are subscribed to, as ZeroMQ matches: a subscription is a prefix. Bounded: at most
// `max_subscriptions` distinct ones, and none that cannot match what we publish. (libzmq keeps its
// own, unbounded; this bounds our work and memory.) Pipeline thread only; allocates.
class Subscriptions {
 public:
  Subscriptions(int max_subscriptions, runtime::Counters& counters)
      : max_(static_cast<std::size_t>(max_subscriptions)), counters_(counters) {}

  // The topic must outlive its registration; its counts are set at once.
  void Register(Topic& topic);
  void Unregister(Topic& topic);

  // XPUB_VERBOSE reports every subscription, but of a topic's unsubscriptions only the last.
  void Subscribe(std::string_view prefix);
  void Unsubscribe(std::string_view prefix);

 private:
  std::size_t max_;
  runtime::Counters& counters_;
  std::unordered_set<std::string> active_;
  std::vector<Topic*> topics_;
};

}  // namespace styled::publish
