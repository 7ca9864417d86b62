#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "daemon/decide/frame_in_transit.h"
#include "daemon/source/source_frame.h"
#include "model/body/pose.h"
#include "proto/styled/v1/journal.pb.h"

namespace styled::log {

// A styled pose on the canonical body, precise enough to distinguish different poses from rounding
// differences between processor models.
struct RoundedPose {
  // x, y, z, w of each joint in 1/32767: a rotation within 0.01 degrees.
  std::array<std::int16_t, std::size_t{4} * body::kJointCount> rotations{};
  std::array<std::int32_t, 3> hips{};  // position in 0.1 mm
};
RoundedPose Rounded(const body::Pose& pose) noexcept;

// Thresholds above which two poses count as different. Rounding differences between processor
// models are far smaller, and smaller differences are not visible.
inline constexpr double kApart_deg = 0.1;
inline constexpr double kApart_m = 0.002;
// Whether a joint is turned by more than kApart_deg, or the hips are moved by more than kApart_m.
bool AreApart(const RoundedPose& a, const RoundedPose& b) noexcept;

// Result of comparing this daemon's frame with the leader's.
enum class Comparison : std::uint8_t {
  kSame,      // bit for bit
  kLastBits,  // rounding differences only
  kApart,     // poses that are apart, or only one daemon has styled the frame
};
Comparison Compare(const decide::FrameInTransit& here,
                   const decide::FrameInTransit& leaders) noexcept;

// Writes a frame or body as an entry of the journal. Allocates.
void Write(const decide::FrameInTransit& frame, v1::Handled& entry);
// Reads a frame from an entry, with views into the entry and a pointer to `given`. Returns false
// for an entry that no daemon writes.
bool Read(const v1::Handled& entry, source::SourceFrame& given, decide::FrameInTransit& frame);

}  // namespace styled::log
