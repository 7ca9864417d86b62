#include "daemon/publish/subscriptions.h"

#include <algorithm>
#include <array>

namespace styled::publish {
namespace {

// Longer than any published topic: "styled/" 32 "." 32 "/canonical/".
constexpr std::size_t kLongest = 96;

bool CanMatch(std::string_view prefix) {
  constexpr std::array<std::string_view, 5> kRoots{"styled/", "source/", "body/", "frames/",
                                                   "stats/"};
  return prefix.size() <= kLongest &&
         std::any_of(kRoots.begin(), kRoots.end(), [prefix](std::string_view root) {
           return root.starts_with(prefix) || prefix.starts_with(root);
         });
}

bool Matches(std::string_view prefix, const Topic& topic) {
  return prefix.size() >= topic.least_prefix && topic.name.starts_with(prefix);
}

}  // namespace

void Subscriptions::Register(Topic& topic) {
  topic.wanted = 0;
  for (const auto& prefix : active_) topic.wanted += Matches(prefix, topic);
  topics_.push_back(&topic);
}

void Subscriptions::Unregister(Topic& topic) { std::erase(topics_, &topic); }

void Subscriptions::Subscribe(std::string_view prefix) {
  std::string key(prefix);
  const bool known = active_.contains(key);
  if (!known && (active_.size() >= max_ || !CanMatch(prefix))) {
    counters_.Add(runtime::Counter::kPublishSubscriptionsRefused);
    return;
  }
  for (Topic* topic : topics_) {
    if (!Matches(prefix, *topic)) continue;
    topic->wanted += known ? 0 : 1;
    topic->asked = true;
  }
  if (!known) active_.insert(std::move(key));
  counters_.Set(runtime::Counter::kPublishSubscriptions, active_.size());
}

void Subscriptions::Unsubscribe(std::string_view prefix) {
  if (active_.erase(std::string(prefix)) == 0) return;
  for (Topic* topic : topics_) topic->wanted -= Matches(prefix, *topic);
  counters_.Set(runtime::Counter::kPublishSubscriptions, active_.size());
}

}  // namespace styled::publish
