#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/publish/publisher.h"
#include "daemon/runtime/clock.h"

namespace styled::standby {

// A standby's publisher: it keeps the last messages instead of sending them, until the standby
// leads. It sends them then: the leader may have died with the same ones in its queues. Subscribers
// drop those that they have by epoch and sequence. Pipeline thread.
class BufferedPublisher final : public publish::Publisher {
 public:
  // What a leader that is killed takes with it has lain in its queues for some milliseconds.
  static constexpr std::int64_t kKeep_ns = 150'000'000;
  static constexpr std::size_t kMost = 8192;

  BufferedPublisher(publish::Publisher& to, const runtime::Clock& clock) : to_(to), clock_(clock) {}

  void Send(std::string_view topic, std::span<const std::byte> payload) noexcept override;
  bool NextSubscription(publish::SubscriptionEvent& event) override {
    return to_.NextSubscription(event);
  }
  void MakeRoom(std::size_t messages) override { to_.MakeRoom(messages); }
  int fd() const override { return to_.fd(); }

  void Hold() { holds_ = true; }
  // Sends what it kept (`all`), after it has made room for it, or drops it; passes on from now on.
  // Returns how many messages it sent.
  std::size_t Release(bool all);

 private:
  struct Message {
    std::int64_t at_ns = 0;
    std::string topic;
    std::vector<std::byte> payload;
  };
  publish::Publisher& to_;
  const runtime::Clock& clock_;
  bool holds_ = false;
  std::deque<Message> kept_;
};

}  // namespace styled::standby
