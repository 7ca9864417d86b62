#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::devices {

using body::Quat;
using body::Vec3;

// An arm or a leg of the canonical humanoid: its joints, and its geometry in the T-pose.
struct Limb {
  int upper, lower, end;
  Vec3 along;  // unit: from the upper joint to the end
  Vec3 hinge;  // unit: the axis about which the lower joint bends, so that positive angles flex it
};
// 0 .. 3: left arm, right arm, left leg, right leg.
inline constexpr int kLimbs = 4;
STYLED_REALTIME const Limb& LimbOf(int index) noexcept;

// Turns upper and lower joint so that the end reaches `target_m`, with the middle joint towards
// `pole` (any length) from the line between the ends. Two-bone IK (model/feet/two_bone_ik.h) of a
// limb that begins straight. `root_m`: the place of the upper joint. Writes world rotations. A
// target out of reach straightens the limb towards it. No state; any thread.
struct LimbTurns {
  Quat upper, lower;
};
STYLED_REALTIME LimbTurns Bend(const Limb& limb, const Vec3& root_m, const Vec3& target_m,
                               const Vec3& pole) noexcept;

// The smallest turn of `rotation` after which `offset` (in the joint's frame) points to `towards`
// (in the world). Unchanged if one of both is too short to have a direction.
STYLED_REALTIME Quat Aim(const Quat& rotation, const Vec3& offset, const Vec3& towards) noexcept;

}  // namespace styled::devices
