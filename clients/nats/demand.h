#pragma once

#include <set>
#include <string>
#include <string_view>

namespace styled::stylenats {

// The topics that the programs of this machine have subscribed to, and the NATS subjects that they
// need. Only frames that a program reads cross the network. One thread; allocates. Pinned by
// tests/unit/nats/demand_test.cpp.
class Demand {
 public:
  // Beyond this number of topics, all frames of the site are requested.
  static constexpr std::size_t kMostSubjects = 256;

  explicit Demand(std::string site) : site_(std::move(site)) {}

  // A topic in the form of ZeroMQ's subscriptions: a prefix (proto/styled/v1/WIRE.md). False:
  // nothing changed.
  bool Add(std::string_view topic) { return topics_.emplace(topic).second; }
  bool Remove(std::string_view topic) { return topics_.erase(std::string(topic)) > 0; }

  // None covers another, so that no message comes twice. Streams that are not passed on to NATS
  // (source/, frames/) need none.
  std::set<std::string> Subjects() const;
  // Whether a message of that topic has a subscriber.
  bool IsSubscribed(std::string_view topic) const;

 private:
  std::string site_;
  std::set<std::string> topics_;
};

// "styled/PERFORMER/STREAM/" of "styled.SITE.PERFORMER.STREAM"; empty for other subjects, for names
// that a daemon does not have, and for the audience tier.
std::string TopicOf(std::string_view subject);
// "body/PERFORMER/" of the key "SITE.body.PERFORMER.STREAM"; empty for other keys.
std::string BodyTopicOf(std::string_view key);

}  // namespace styled::stylenats
