#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/stylizer.h"
#include "model/rig/binding.h"

namespace styled::stylist {

// Decides whether a pose may be published. Finite weights can still compute infinities, and
// receivers must be able to trust every pose: all values are finite, rotations have length 1, and
// the body is within tuning::kFarthest_m of the performer's own. Pure, no allocation; any thread.
// Pinned by tests/unit/stylist/guard_test.cpp.

// The network's output: finite, rotations of length 1.
STYLED_REALTIME bool IsSound(const net::Prediction& step) noexcept;

// The canonical pose `styled` compared with the performer's own, `moved_m` from the performer's
// place because of a stride.
STYLED_REALTIME bool IsSound(const body::Pose& styled, const body::Pose& own,
                             const body::Vec3& moved_m = body::Vec3::Zero()) noexcept;

// The same on a skeleton, joint by joint; `own` is finite.
STYLED_REALTIME bool IsSound(const rig::Binding& binding, const rig::RigPose& styled,
                             const rig::RigPose& own,
                             const body::Vec3& moved_m = body::Vec3::Zero()) noexcept;

// `pose` on its skeleton, compared with the canonical pose that it was made from.
STYLED_REALTIME bool IsSound(const rig::Binding& binding, const rig::RigPose& pose,
                             const body::Pose& canonical) noexcept;

}  // namespace styled::stylist
