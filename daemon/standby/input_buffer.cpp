#include "daemon/standby/input_buffer.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "model/base/crc32c.h"

namespace styled::standby {
namespace {

// A frame that the leader had within this time of the standby's is taken for the same one where
// nothing else tells: less than half a period at 120 Hz.
constexpr std::int64_t kSameTime_ns = 4'000'000;
// Bounds what invented names may occupy.
constexpr std::size_t kMostBodies = 1024;

}  // namespace

std::uint32_t PoseCrc(const source::SourceFrame& frame) noexcept {
  const std::uint32_t root = Crc32c(frame.root_position);
  return Crc32c(frame.rotations) ^ ((root << 1U) | (root >> 31U));
}

std::unique_ptr<InputBuffer::Frame> InputBuffer::Keep(int source, const source::SourceFrame& frame,
                                                      std::int64_t now_ns) {
  auto held = free_.empty() ? std::make_unique<Frame>() : std::move(free_.back());
  if (!free_.empty()) free_.pop_back();
  held->source = source;
  held->at_ns = now_ns;
  held->frame = held->memory.Keep(frame);
  held->pose_crc = frame.is_body ? 0 : PoseCrc(frame);
  return held;
}

void InputBuffer::Add(int source, std::span<const source::SourceFrame> frames,
                      std::int64_t now_ns) {
  for (const source::SourceFrame& frame : frames) {
    if (frame.is_body) {
      const std::pair key(source, std::string(frame.performer));
      if (bodies_.size() >= kMostBodies && !bodies_.contains(key)) continue;
      bodies_[key] = Keep(source, frame, now_ns);
      continue;
    }
    frames_.push_back(Keep(source, frame, now_ns));
  }
  DropOld(now_ns);
}

void InputBuffer::DropOld(std::int64_t now_ns) {
  while (!frames_.empty() &&
         (frames_.size() > kMost || now_ns - frames_.front()->at_ns > kKeep_ns)) {
    frames_.front()->frame.body.reset();
    free_.push_back(std::move(frames_.front()));
    frames_.pop_front();
  }
}

void InputBuffer::Expire(const std::vector<std::string>& source_names, std::int64_t now_ns) {
  DropOld(now_ns);
  std::erase_if(bodies_, [&](const auto& body) {
    const std::string& source = source_names[static_cast<std::size_t>(body.first.first)];
    return now_ns - body.second->at_ns > kKeep_ns &&
           LastOf(source_names, source + "." + body.first.second) ==
               std::numeric_limits<std::int64_t>::min();
  });
}

void InputBuffer::Clear() {
  frames_.clear();
  bodies_.clear();
  free_.clear();
}

bool InputBuffer::IsOf(const Frame& held, const std::vector<std::string>& source_names,
                       std::string_view id) {
  const std::string& source = source_names[static_cast<std::size_t>(held.source)];
  return id.size() == source.size() + 1 + held.frame.performer.size() && id.starts_with(source) &&
         id.ends_with(held.frame.performer);
}

std::int64_t InputBuffer::LastOf(const std::vector<std::string>& source_names,
                                 std::string_view id) const {
  const auto last = std::find_if(frames_.rbegin(), frames_.rend(),
                                 [&](const auto& held) { return IsOf(*held, source_names, id); });
  return last == frames_.rend() ? std::numeric_limits<std::int64_t>::min() : (*last)->at_ns;
}

InputBuffer::Place InputBuffer::Find(const std::vector<std::string>& source_names,
                                     std::string_view id, const LastHandled& last) const {
  Place by_number, by_pose, by_time;
  std::int64_t nearest_ns = std::numeric_limits<std::int64_t>::max();
  bool numbered = false;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const Frame& held = *frames_[i];
    if (!IsOf(held, source_names, id)) continue;
    if (held.frame.session == last.session) {
      numbered = true;
      if (held.frame.sequence <= last.sequence) by_number.after = i + 1;
      if (held.frame.sequence == last.sequence) by_number.same = &held;
    }
    const std::int64_t apart_ns = std::abs(held.at_ns - last.at_ns);
    if (held.pose_crc == last.pose_crc && apart_ns < nearest_ns) {
      nearest_ns = apart_ns;
      by_pose = {&held, i + 1};
    }
    if (held.at_ns <= last.at_ns + kSameTime_ns) by_time = {&held, i + 1};
  }
  if (numbered) return by_number;
  return by_pose.same != nullptr ? by_pose : by_time;
}

}  // namespace styled::standby
