#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "clients/web/mailbox.h"
#include "clients/web/metrics.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::web {

// A browser connection, as the hub uses it.
class Browser {
 public:
  virtual ~Browser() = default;
  virtual void Offer(const MessagePtr& message) = 0;  // must not call back into the hub
};

enum class Subscribed : std::uint8_t {
  kOk,       // subscribed now or before
  kNoTopic,  // not a topic of clients/web/topics.h
  kTooMany,  // this browser has kMaxTopics, or all together have kMaxDistinctTopics
};

// Distributes the daemon's messages to the browsers that subscribed to them. The hub subscribes at
// the daemon only to topics that a browser wants, and always to stats/. It caches bodies and the
// last statistics for browsers that connect later, and tracks whether a daemon is publishing.
//
// One thread at a time. Allocates. Pinned by tests/unit/web/hub_test.cpp.
class Hub {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::size_t kMaxTopics = 256;  // per browser
  // The daemon's own limit is 1024 by default.
  static constexpr std::size_t kMaxDistinctTopics = 512;
  // Without stats/, which is sent every second: the daemon is down.
  static constexpr std::chrono::seconds kSilence{3};

  struct Upward {
    std::function<void(const std::string&)> subscribe, unsubscribe;
  };
  // `endpoint` appears in the message that no daemon publishes.
  Hub(std::string endpoint, Upward upward, Counters& counters, Clock::time_point now);

  void Join(Browser& browser);  // sends it the daemon's state
  void Leave(Browser& browser);
  Subscribed Subscribe(Browser& browser, const std::string& topic);
  void Unsubscribe(Browser& browser, const std::string& topic);

  // Distributes a message of the daemon. A body is passed on only if it is new or changed.
  void Publish(std::string_view topic, std::string_view payload, Clock::time_point now);
  void Disconnected(Clock::time_point now) { SetUp(false, now); }
  void Tick(Clock::time_point now);  // call regularly
  // Sets the known reason why no daemon publishes; browsers are notified when it changes.
  void SetObstacle(const std::string& obstacle);

  bool daemon_up() const { return up_; }
  // Why the daemon is down, and since when: "no daemon publishes at ... (4 s)". "" if it is up.
  std::string Reason(Clock::time_point now) const;
  const v1::Stats* statistics() const { return up_ && has_stats_ ? &stats_ : nullptr; }
  std::size_t browsers() const { return browsers_.size(); }

 private:
  using Browsers = std::vector<Browser*>;
  void SetUp(bool up, Clock::time_point now);
  std::string NobodyThere() const;
  MessagePtr DaemonNotice() const;
  void Deliver(const Browsers& to, const MessagePtr& message);
  void PublishBody(std::string_view topic, std::string_view payload);
  void ForgetBodies(std::string_view topic);

  struct CachedBody {
    std::uint64_t hash = 0;
    MessagePtr message;
  };
  std::string endpoint_, obstacle_;
  Upward upward_;
  Counters& counters_;
  std::map<Browser*, std::vector<std::string>> browsers_;  // with their topics
  std::map<std::string, Browsers, std::less<>> wanted_;    // by topic
  std::map<std::string, CachedBody, std::less<>> bodies_;  // by topic and output
  MessagePtr last_stats_;
  v1::Stats stats_;
  bool up_ = false, has_stats_ = false;
  Clock::time_point changed_, heard_;
};

// Encodes a message for browsers (clients/web/WIRE.md): the topic's length, the topic, the payload.
// An empty topic marks a Reply.
std::string Packed(std::string_view topic, std::string_view payload);

}  // namespace styled::web
