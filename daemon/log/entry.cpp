#include "daemon/log/entry.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <string_view>

#include "model/base/text.h"
#include "proto/styled/timecode_message.h"

namespace styled::log {
namespace {

std::string_view Text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> Bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

constexpr double kRotationUnit = 32767;
constexpr double kHipsPerMetre = 10'000;
static_assert(sizeof(RoundedPose) == sizeof(RoundedPose::rotations) + sizeof(RoundedPose::hips),
              "its bytes are those of the journal");

// Replaces values that are not finite by 0.
template <typename T>
T RoundTo(double value, double most) noexcept {
  return std::isfinite(value) ? static_cast<T>(std::lround(std::clamp(value, -most, most))) : T{0};
}

bool ReadRounded(std::span<const std::byte> bytes, RoundedPose& pose) noexcept {
  if (bytes.size() != sizeof pose) return false;
  std::memcpy(&pose, bytes.data(), sizeof pose);
  return true;
}

}  // namespace

RoundedPose Rounded(const body::Pose& pose) noexcept {
  RoundedPose rounded;
  for (std::size_t joint = 0; joint < pose.rotations.size(); ++joint) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double value = pose.rotations[joint].coeffs()[static_cast<Eigen::Index>(k)];
      rounded.rotations[4 * joint + k] =
          RoundTo<std::int16_t>(value * kRotationUnit, kRotationUnit);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    constexpr double kMost = 2'147'483'647;
    const double position_m = pose.hips_position_m[static_cast<Eigen::Index>(k)];
    rounded.hips[k] = RoundTo<std::int32_t>(position_m * kHipsPerMetre, kMost);
  }
  return rounded;
}

bool AreApart(const RoundedPose& a, const RoundedPose& b) noexcept {
  double squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double apart_m = (static_cast<double>(a.hips[k]) - b.hips[k]) / kHipsPerMetre;
    squared += apart_m * apart_m;
  }
  if (squared > kApart_m * kApart_m) return true;
  // Half of the angle between two rotations is that between their quaternions.
  static const double least = std::cos(kApart_deg / 2 * std::numbers::pi / 180);
  for (std::size_t at = 0; at < a.rotations.size(); at += 4) {
    double dot = 0, a_squared = 0, b_squared = 0;
    for (std::size_t k = at; k < at + 4; ++k) {
      const double x = a.rotations[k], y = b.rotations[k];
      dot += x * y;
      a_squared += x * x;
      b_squared += y * y;
    }
    if (!(std::abs(dot) > least * std::sqrt(a_squared * b_squared))) return true;
  }
  return false;
}

Comparison Compare(const decide::FrameInTransit& here,
                   const decide::FrameInTransit& leaders) noexcept {
  if (here.decision.fate != leaders.decision.fate) return Comparison::kApart;
  if (here.styled_crc == leaders.styled_crc) return Comparison::kSame;
  RoundedPose a, b;
  const bool poses = ReadRounded(here.rounded_pose, a) && ReadRounded(leaders.rounded_pose, b);
  return poses && !AreApart(a, b) ? Comparison::kLastBits : Comparison::kApart;
}

void Write(const decide::FrameInTransit& transit, v1::Handled& entry) {
  const source::SourceFrame& frame = *transit.given;
  entry.set_performer(frame.performer.data(), frame.performer.size());
  entry.set_machine(frame.machine.data(), sizeof frame.machine);
  entry.set_session(frame.session);
  entry.set_sequence(frame.sequence);
  entry.set_body_crc(frame.body_crc);
  entry.set_is_body(frame.is_body);
  if (frame.is_body) {
    if (frame.refusal != nullptr) entry.set_refusal(*frame.refusal);
    if (frame.body != nullptr) {
      frame.body->SerializeToString(entry.mutable_body());
    } else {
      *entry.mutable_body() = Text(frame.body_bytes);
    }
    return;
  }
  entry.set_source_time_ns(frame.source_time_ns);
  if (frame.has_timecode) WriteTimecode(frame.timecode, *entry.mutable_timecode());
  *entry.mutable_root_position() = Text(frame.root_position);
  *entry.mutable_rotations() = Text(frame.rotations);
  *entry.mutable_face() = Text(frame.face);
  *entry.mutable_props() = Text(frame.props);
  entry.set_scene_props(frame.scene_props);
  entry.set_fate(transit.decision.fate);
  entry.set_late(transit.decision.late);
  entry.set_published(transit.decision.sequence);
  entry.set_styled_crc(transit.styled_crc);
  *entry.mutable_rounded_pose() = Text(transit.rounded_pose);
  entry.set_relieved(transit.decision.relieved);
}

bool Read(const v1::Handled& entry, source::SourceFrame& frame, decide::FrameInTransit& transit) {
  frame = source::SourceFrame();
  transit = decide::FrameInTransit();
  transit.given = &frame;
  if (entry.machine().size() != sizeof frame.machine) return false;
  std::memcpy(frame.machine.data(), entry.machine().data(), sizeof frame.machine);
  frame.performer = entry.performer();
  frame.session = entry.session();
  frame.sequence = entry.sequence();
  frame.body_crc = entry.body_crc();
  frame.is_body = entry.is_body();
  if (frame.is_body) {
    constexpr std::size_t kLongest = 2000;
    frame.body_bytes = Bytes(entry.body());
    if (!entry.refusal().empty()) {
      frame.refusal = std::make_shared<const std::string>(Printable(entry.refusal(), kLongest));
    }
    return true;
  }
  frame.source_time_ns = entry.source_time_ns();
  frame.has_timecode = entry.has_timecode();
  const v1::Timecode& from = entry.timecode();
  frame.timecode = {from.hours(),  from.minutes(), from.seconds(),
                    from.frames(), from.rate(),    from.drop_frame()};
  frame.root_position = Bytes(entry.root_position());
  frame.rotations = Bytes(entry.rotations());
  frame.face = Bytes(entry.face());
  frame.props = Bytes(entry.props());
  frame.scene_props = entry.scene_props();
  transit.decision.fate = entry.fate();
  transit.decision.late = entry.late();
  transit.decision.sequence = entry.published();
  transit.decision.relieved = entry.relieved();
  transit.styled_crc = entry.styled_crc();
  transit.rounded_pose = Bytes(entry.rounded_pose());
  return true;
}

}  // namespace styled::log
