#pragma once

#include <Eigen/Geometry>
#include <array>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/humanoid.h"

namespace styled::body {

using Vec3 = Eigen::Vector3f;
using Quat = Eigen::Quaternionf;  // stored x,y,z,w

// One pose of the canonical humanoid. `rotations[j]` is joint j's rotation relative to its parent
// (the hips' relative to the world), unit length, identity at rest. Joint order: body::Joint.
struct Pose {
  Vec3 hips_position_m = Vec3(0, kHumanoid[kHips].y_m, 0);
  std::array<Quat, kJointCount> rotations;

  Pose() { rotations.fill(Quat::Identity()); }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(hips_position_m, rotations); }
};

// The same pose in world space.
struct WorldPose {
  std::array<Vec3, kJointCount> positions_m;
  std::array<Quat, kJointCount> rotations;
};

// The joint's offset from its parent at rest, metres.
inline Vec3 Offset(int joint) {
  const JointRow& row = kHumanoid[joint];
  return {row.x_m, row.y_m, row.z_m};
}

// Forward kinematics over the table's offsets. No state, no allocation; any thread.
// Pinned by tests/unit/body/pose_test.cpp.
STYLED_REALTIME void ForwardKinematics(const Pose& pose, WorldPose& world) noexcept;

// The pose between `a` (share 0) and `b` (share 1): positions linear, rotations by slerp along the
// shorter arc. For short gaps in a stream; clips are resampled with clip::Resample instead.
STYLED_REALTIME void Interpolate(const Pose& a, const Pose& b, float share, Pose& out) noexcept;

// Swaps left and right by reflection through the plane x = 0. Mirroring twice gives the pose back.
// `out` may be `pose`.
STYLED_REALTIME void Mirror(const Pose& pose, Pose& out) noexcept;

// The height of the lowest of the feet and toes, metres, world.
STYLED_REALTIME float LowestFoot_m(const WorldPose& world) noexcept;

// The logarithm of a unit quaternion as a rotation vector (axis times angle in radians, angle <=
// pi). Accurate near the identity.
STYLED_REALTIME Vec3 Log(const Quat& rotation) noexcept;

// The same rotation as a rotation vector the shorter or the longer way round, whichever is closer
// to `near`. A filter over time needs this: the vector must not change sides where a rotation
// passes 180 degrees. Rotations below 90 degrees always go the shorter way.
STYLED_REALTIME Vec3 LogNear(const Quat& rotation, const Vec3& near) noexcept;
// The inverse of Log: the unit quaternion of a rotation vector.
STYLED_REALTIME Quat Exp(const Vec3& rotation_vector) noexcept;

// The rotation by the smallest angle that turns the direction of `from` into that of `to`; neither
// may be 0. Eigen's FromTwoVectors, compiled once: it instantiates a singular value decomposition.
STYLED_REALTIME Quat ShortestTurn(const Vec3& from, const Vec3& to) noexcept;

}  // namespace styled::body
