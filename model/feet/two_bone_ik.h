#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::feet {

using body::Quat;
using body::Vec3;

// A limb of two bones as it is, all in one space and unit.
struct TwoBones {
  Vec3 hip, knee, ankle;
  Vec3 hinge;  // unit; the knee's anatomical axis: decides the side where the leg is straight
};

// What to turn, in the same space: `upper` turns the whole limb about the hip, `lower` what is
// below the knee about the knee, before `upper` is applied.
struct TwoBoneTurns {
  Quat lower = Quat::Identity(), upper = Quat::Identity();
  float missed = 0;  // how far the ankle stays from the target
};

// Brings the ankle to `target` by rotations alone, so the bones keep their lengths. First the
// knee's angle by the law of cosines, about the axis it bends about now (about `hinge` where the
// limb is straight within some degrees, blended between), so that it keeps its side; then the
// shortest arc about the hip. Out of reach, the ankle ends on the line to the target as far (or
// near) as the bones allow; on that line, too, it stays short or goes too far where a knee that is
// bent backwards would have to snap through. A target at the ankle gives the identity. No state, no
// allocation; any thread. Pinned by tests/unit/feet/two_bone_ik_test.cpp.
STYLED_REALTIME TwoBoneTurns ReachFor(const TwoBones& limb, const Vec3& target) noexcept;

// How far a limb of length `length` goes when `wanted` is asked for: hardly less well below its
// length, half a `corner` less at it, never the whole of it. The knee's angle is a smooth function
// of `wanted`, where the law of cosines alone would snap it straight.
STYLED_REALTIME float SoftReach(float wanted, float length, float corner) noexcept;

}  // namespace styled::feet
