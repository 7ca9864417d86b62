#include "daemon/publish/frame_message.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "proto/styled/timecode_message.h"

namespace styled::publish {

FrameMessage::FrameMessage(const std::string& performer, std::uint64_t epoch, const v1::Body& body,
                           int rig_joints, const net::Styles& styles)
    : spare_timecode_(std::make_unique<v1::Timecode>()), styles_(&styles) {
  std::size_t longest = net::kMaxStyleName;
  for (const auto& style : styles) longest = std::max(longest, style.name.size());
  frame_.set_performer(performer);
  frame_.set_epoch(epoch);
  frame_.set_output(body.output());
  frame_.set_body_hash(body.hash());
  frame_.mutable_root_position()->Resize(3, 0);
  frame_.mutable_rotations()->Resize(4 * body.names_size(), 0);
  // Fills the variable fields to their largest size once, because protobuf keeps cleared elements
  // for reuse.
  frame_.mutable_held_joints()->Resize(rig_joints, 1U << 14U);
  for (int i = 0; i < net::kMaxActive; ++i) {
    auto* const style = frame_.add_styles();
    style->set_style(std::string(longest, 'x'));
    style->set_weight(1);
  }
  constexpr std::size_t kScalars = 256;  // 17 fields, including the timecode
  buffer_.resize(frame_.ByteSizeLong() + kScalars + kMaxFace + kMaxPropBytes);
  frame_.clear_held_joints();
  frame_.clear_styles();
}

void FrameMessage::SetHeader(const decide::FrameInTransit& frame, std::uint32_t flags) noexcept {
  frame_.set_sequence(frame.decision.sequence);
  frame_.set_source_sequence(frame.source_sequence);
  frame_.set_source_time_ns(frame.source_time_ns);
  frame_.set_receive_time_ns(static_cast<std::uint64_t>(frame.arrival_ns));
  frame_.set_publish_time_ns(static_cast<std::uint64_t>(frame.publish_ns));
  frame_.set_wall_time_ns(static_cast<std::uint64_t>(frame.wall_ns));
  frame_.set_contacts(frame.contacts);
  frame_.set_flags(flags);
  frame_.clear_held_joints();
  if (!frame.has_timecode) {
    if (frame_.has_timecode()) spare_timecode_.reset(frame_.unsafe_arena_release_timecode());
    return;
  }
  if (!frame_.has_timecode()) {
    frame_.unsafe_arena_set_allocated_timecode(spare_timecode_.release());
  }
  WriteTimecode(frame.timecode, *frame_.mutable_timecode());
}

void FrameMessage::SetStyles(std::span<const net::StyleWeight> in_force) noexcept {
  frame_.clear_styles();
  for (const auto& active : in_force) {
    if (active.style < 0 || active.style >= static_cast<int>(styles_->size())) continue;
    auto* const style = frame_.add_styles();
    style->set_style((*styles_)[static_cast<std::size_t>(active.style)].name);
    style->set_weight(active.weight);
  }
}

void FrameMessage::AddHeld(int joint) noexcept {
  frame_.add_held_joints(static_cast<std::uint32_t>(joint));
}

void FrameMessage::SetPose(const rig::Vec3& root_position,
                           std::span<const rig::Quat> rotations) noexcept {
  assert(static_cast<std::size_t>(frame_.rotations_size()) == 4 * rotations.size());
  std::memcpy(frame_.mutable_root_position()->mutable_data(), root_position.data(),
              3 * sizeof(float));
  std::memcpy(frame_.mutable_rotations()->mutable_data(), rotations.front().coeffs().data(),
              4 * sizeof(float) * rotations.size());
}

std::span<const std::byte> FrameMessage::Serialize(std::span<const std::byte> face,
                                                   std::span<const std::byte> props) noexcept {
  const std::size_t size = frame_.ByteSizeLong();
  const std::size_t whole = size + face.size() + props.size();
  if (whole > buffer_.size()) return {};  // impossible: sized for the largest frame
  auto* const begin = reinterpret_cast<std::uint8_t*>(buffer_.data());
  frame_.SerializeWithCachedSizesToArray(begin);
  const auto behind =
      std::copy(face.begin(), face.end(), buffer_.begin() + static_cast<std::ptrdiff_t>(size));
  std::copy(props.begin(), props.end(), behind);
  return {buffer_.data(), whole};
}

}  // namespace styled::publish
