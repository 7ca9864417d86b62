#include "model/body/pose.h"

#include <algorithm>
#include <cmath>

namespace styled::body {

void ForwardKinematics(const Pose& pose, WorldPose& world) noexcept {
  world.positions_m[kHips] = pose.hips_position_m;
  world.rotations[kHips] = pose.rotations[kHips];
  for (int joint = 1; joint < kJointCount; ++joint) {
    const int parent = kHumanoid[joint].parent;
    world.positions_m[joint] = world.positions_m[parent] + world.rotations[parent] * Offset(joint);
    world.rotations[joint] = world.rotations[parent] * pose.rotations[joint];
  }
}

void Interpolate(const Pose& a, const Pose& b, float share, Pose& out) noexcept {
  out.hips_position_m = a.hips_position_m + share * (b.hips_position_m - a.hips_position_m);
  for (int joint = 0; joint < kJointCount; ++joint) {
    out.rotations[joint] = a.rotations[joint].slerp(share, b.rotations[joint]).normalized();
  }
}

void Mirror(const Pose& pose, Pose& out) noexcept {
  const Pose source = pose;  // `out` may be `pose`
  out.hips_position_m = source.hips_position_m.cwiseProduct(Vec3(-1, 1, 1));
  for (int joint = 0; joint < kJointCount; ++joint) {
    const Quat& q = source.rotations[MirrorJoint(joint)];
    // A reflection through x = 0 keeps the x component of the rotation and negates y and z.
    out.rotations[joint] = Quat(q.w(), q.x(), -q.y(), -q.z());
  }
}

float LowestFoot_m(const WorldPose& world) noexcept {
  return std::min(std::min(world.positions_m[kLeftFoot].y(), world.positions_m[kLeftToes].y()),
                  std::min(world.positions_m[kRightFoot].y(), world.positions_m[kRightToes].y()));
}

Vec3 Log(const Quat& rotation) noexcept {
  // q and -q are the same rotation: take the shorter way
  const float sign = rotation.w() < 0 ? -1.0F : 1.0F;
  const Vec3 v = sign * rotation.vec();
  const float sine = v.norm();
  // The factor is angle / sin(angle / 2). Its limit at angle 0 is 2. atan2 keeps it accurate near
  // 0.
  const float scale = sine < 1e-6F ? 2.0F : 2.0F * std::atan2(sine, sign * rotation.w()) / sine;
  return scale * v;
}

Vec3 LogNear(const Quat& rotation, const Vec3& near) noexcept {
  constexpr float kPi = 3.14159265F;
  Vec3 shorter = Log(rotation);
  const float angle = shorter.norm();
  if (angle < 0.5F * kPi) return shorter;
  // The same rotation in the other direction: the same axis, the angle minus a full turn.
  const Vec3 longer = shorter * (1.0F - 2.0F * kPi / angle);
  return (longer - near).squaredNorm() < (shorter - near).squaredNorm() ? longer : shorter;
}

Quat ShortestTurn(const Vec3& from, const Vec3& to) noexcept {
  return Quat::FromTwoVectors(from, to);
}

Quat Exp(const Vec3& rotation_vector) noexcept {
  const float angle = rotation_vector.norm();
  const float scale = angle < 1e-6F ? 0.5F : std::sin(0.5F * angle) / angle;
  Quat out;
  out.w() = std::cos(0.5F * angle);
  out.vec() = scale * rotation_vector;
  return out;
}

}  // namespace styled::body
