#pragma once

#include <optional>
#include <span>

#include "model/rig/binding.h"

// The up axis of a motion, where it is another than that of the pose in which its skeleton was
// bound: a body modelled with +Y up whose every frame is turned to +Z up at the root. Allocates;
// any thread. Pinned by tests/unit/rig/motion_up_test.cpp.
namespace styled::rig {

// The source's up axis by `binding`: the one that becomes the humanoid's +Y.
Vec3 UpOf(const Binding& binding);

// The source axis along which trunk and legs stand in most of `poses`, if it is not UpOf(binding);
// nothing if they stand along that, or along no axis. Poses that lie along an axis have it, too:
// StandsOnFloor tells.
std::optional<Vec3> UpOfMotion(const Binding& binding, std::span<const RigPose> poses);

// Whether the hips are as far above the origin, along the up axis, as those of a body that stands,
// walks or jumps there: in most of `poses`. Motion without a floor at its origin does not.
bool StandsOnFloor(const Binding& binding, std::span<const RigPose> poses);

// The binding of the same skeleton for motion whose up axis is `up`, a unit axis of the source: its
// T-pose stands along `up`, turned by the shortest way.
Result<Binding> WithUp(const Binding& binding, const Vec3& up);

}  // namespace styled::rig
