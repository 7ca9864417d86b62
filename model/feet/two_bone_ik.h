#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::feet {

using body::Quat;
using body::Vec3;

// A limb of two bones in its present pose, all in one space and unit.
struct TwoBones {
  Vec3 hip, knee, ankle;
  Vec3 hinge;  // unit; the knee's anatomical axis, which decides the side of a straight limb
};

// The rotations to apply, in the same space: `lower` turns what is below the knee about the knee,
// then `upper` turns the whole limb about the hip.
struct TwoBoneTurns {
  Quat lower = Quat::Identity(), upper = Quat::Identity();
  float missed = 0;  // the distance between the ankle and the target afterwards
};

// The turn of a knee that brings the ankle to a given distance from the hip.
struct KneeTurn {
  Vec3 axis = Vec3::UnitX();  // unit; of the turn
  float bend_rad = 0;         // now, about the axis: 0 is straight, negative beyond
  float turn_rad = 0;         // to be added to it
};
STYLED_REALTIME KneeTurn KneeFor(const TwoBones& limb, float distance) noexcept;
// The turns that bend the knee by that angle and bring the ankle onto the line to `target`.
STYLED_REALTIME TwoBoneTurns Turn(const TwoBones& limb, const Vec3& axis, float turn_rad,
                                  const Vec3& target) noexcept;

// Both steps. Brings the ankle to `target` by rotations only, so the bones keep their lengths. The
// first step sets the knee's angle by the law of cosines, about the axis about which the knee bends
// now, so that it keeps its side; `hinge` is blended in when the limb is nearly straight. The
// second step is the shortest arc about the hip. If the target is out of reach, the ankle ends on
// the line to it, as far (or near) as the bones allow. It also stops short of the target, or passes
// it, on that line if a knee that is bent backwards would have to snap through. A target at the
// ankle returns the identity. No state, no allocation; any thread. Pinned by
// tests/unit/feet/two_bone_ik_test.cpp.
STYLED_REALTIME TwoBoneTurns ReachFor(const TwoBones& limb, const Vec3& target) noexcept;

// A soft limit on the reach of a limb of length `length`. The result is about `wanted` well below
// the length, half a `corner` less than the length at it, and always less than the length. With it
// the knee's angle is a smooth function of `wanted`; the law of cosines alone would snap the knee
// straight.
STYLED_REALTIME float SoftReach(float wanted, float length, float corner) noexcept;

}  // namespace styled::feet
