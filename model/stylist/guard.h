#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/stylizer.h"
#include "model/rig/binding.h"

namespace styled::stylist {

// What may be published at all. Weights that are finite can still compute infinities, and nothing
// behind the daemon is to be trusted with a pose that is none: all values finite, rotations of
// length 1, the body within tuning::kFarthest_m of the performer's own. Pure, no allocation; any
// thread. Pinned by tests/unit/stylist/guard_test.cpp.

// What the network decoded: finite, rotations of length 1.
STYLED_REALTIME bool IsSound(const net::Prediction& step) noexcept;

// The canonical pose `styled` against the performer's own.
STYLED_REALTIME bool IsSound(const body::Pose& styled, const body::Pose& own) noexcept;

// The same on a skeleton, joint by joint; `own` is finite. `metres`: the length of one unit.
STYLED_REALTIME bool IsSound(const rig::RigPose& styled, const rig::RigPose& own,
                             float metres) noexcept;

// `pose` on its skeleton against the canonical pose that it was made from.
STYLED_REALTIME bool IsSound(const rig::Binding& binding, const rig::RigPose& pose,
                             const body::Pose& canonical) noexcept;

}  // namespace styled::stylist
