#include "daemon/standby/buffered_publisher.h"

namespace styled::standby {

void BufferedPublisher::Send(std::string_view topic, std::span<const std::byte> payload) noexcept {
  // Its own statistics say how the standby is.
  if (!holds_ || topic == "stats/") return to_.Send(topic, payload);
  if (topic.starts_with("body/")) return;  // sent anew then
  const std::int64_t now_ns = clock_.Now_ns();
  while (!kept_.empty() && (kept_.size() >= kMost || now_ns - kept_.front().at_ns > kKeep_ns)) {
    kept_.pop_front();
  }
  kept_.push_back({now_ns, std::string(topic), {payload.begin(), payload.end()}});
}

std::size_t BufferedPublisher::Release(bool all) {
  holds_ = false;
  const std::size_t sent = all ? kept_.size() : 0;
  to_.MakeRoom(sent);
  if (all) {
    for (const Message& message : kept_) to_.Send(message.topic, message.payload);
  }
  kept_.clear();
  return sent;
}

}  // namespace styled::standby
