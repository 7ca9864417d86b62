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

// A styled pose on the canonical body, near enough to tell another pose from one whose last bits
// differ, as on processors of another make.
struct RoundedPose {
  // x, y, z, w of each joint in 1/32767: a rotation within 0.01 degrees.
  std::array<std::int16_t, std::size_t{4} * body::kJointCount> rotations{};
  std::array<std::int32_t, 3> hips{};  // position in 0.1 mm
};
RoundedPose Rounded(const body::Pose& pose) noexcept;

// Beyond these, two poses are no longer the same: what another make of processor computes is nearer
// by far, and nobody sees less.
inline constexpr double kApart_deg = 0.1;
inline constexpr double kApart_m = 0.002;
// Whether a joint is turned by more than kApart_deg, or the hips are moved by more than kApart_m.
bool AreApart(const RoundedPose& a, const RoundedPose& b) noexcept;

// How a daemon's frame compares with the leader's.
enum class Comparison : std::uint8_t {
  kSame,      // bit for bit
  kLastBits,  // poses that differ and are not apart
  kApart,     // poses that are apart, or a frame that only one of them has styled
};
Comparison Compare(const decide::FrameInTransit& here,
                   const decide::FrameInTransit& leaders) noexcept;

// A frame or body as an entry of the journal. Allocates.
void Write(const decide::FrameInTransit& frame, v1::Handled& entry);
// The frame of an entry, with views into it, and `given`, to which it points; false for one that no
// daemon writes.
bool Read(const v1::Handled& entry, source::SourceFrame& given, decide::FrameInTransit& frame);

}  // namespace styled::log
