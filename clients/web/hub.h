#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/web/mailbox.h"
#include "clients/web/metrics.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::web {

// One browser, as the hub sees it.
class Browser {
 public:
  virtual ~Browser() = default;
  virtual void Offer(const MessagePtr& message) = 0;  // does not call back into the hub
};

enum class Subscribed : std::uint8_t {
  kOk,       // or was already
  kNoTopic,  // not one of clients/web/topics.h
  kTooMany,  // this browser's kMaxTopics, or kMaxDistinctTopics of all
};

// Who wants what: what the daemon published goes to the browsers that asked for it, and the daemon
// is asked only for what some browser wants (and stats/, always). Remembers bodies and the last
// statistics for browsers that come later, and whether a daemon is there.
//
// One thread at a time. Allocates. Pinned by tests/unit/web/hub_test.cpp.
class Hub {
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::size_t kMaxTopics = 256;          // of one browser
  static constexpr std::size_t kMaxDistinctTopics = 512;  // the daemon serves 1024 by default
  static constexpr std::chrono::seconds kSilence{3};      // of stats/, which comes every second

  struct Upward {
    std::function<void(const std::string&)> subscribe, unsubscribe;
  };
  // `endpoint` is named where the daemon is said to be away.
  Hub(std::string endpoint, Upward upward, Counters& counters, Clock::time_point now);

  void Join(Browser& browser);  // tells it how the daemon is
  void Leave(Browser& browser);
  Subscribed Subscribe(Browser& browser, const std::string& topic);
  void Unsubscribe(Browser& browser, const std::string& topic);

  // A message of the daemon: bodies are passed on when they are new or changed, all else as it is.
  void Publish(std::string_view topic, std::string_view payload, Clock::time_point now);
  void Disconnected(Clock::time_point now) { SetUp(false, now); }
  void Tick(Clock::time_point now);  // once in a while
  // Why no daemon publishes, as far as is known; browsers are told when it changes.
  void SetObstacle(const std::string& obstacle);

  bool daemon_up() const { return up_; }
  // Why not, and since when: "no daemon publishes at ... (4 s)". "" where it is up.
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
  std::map<Browser*, std::vector<std::string>> browsers_;  // and their topics
  std::map<std::string, Browsers, std::less<>> wanted_;    // by topic
  std::map<std::string, CachedBody, std::less<>> bodies_;  // by topic and output
  MessagePtr last_stats_;
  v1::Stats stats_;
  bool up_ = false, has_stats_ = false;
  Clock::time_point changed_, heard_;
};

// A message as browsers get it (clients/web/WIRE.md): the topic's length, the topic, the payload.
// An empty topic is that of a Reply.
std::string Packed(std::string_view topic, std::string_view payload);

}  // namespace styled::web
