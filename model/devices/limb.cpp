#include "model/devices/limb.h"

#include <array>

#include "model/feet/two_bone_ik.h"

namespace styled::devices {
namespace {

constexpr float kTiny = 1e-4F;

const std::array<Limb, kLimbs> kRows{
    {{body::kLeftUpperArm, body::kLeftLowerArm, body::kLeftHand, {1, 0, 0}, {0, -1, 0}},
     {body::kRightUpperArm, body::kRightLowerArm, body::kRightHand, {-1, 0, 0}, {0, 1, 0}},
     {body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot, {0, -1, 0}, {1, 0, 0}},
     {body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot, {0, -1, 0}, {1, 0, 0}}}};

// `v` without its component along the unit vector `axis`, as a unit vector; `otherwise` if nothing
// is left.
Vec3 Across(const Vec3& v, const Vec3& axis, const Vec3& otherwise) noexcept {
  const Vec3 across = v - v.dot(axis) * axis;
  const float length = across.norm();
  return length > kTiny ? Vec3(across / length) : otherwise;
}

// The rotation that takes the first pair of orthogonal unit vectors to the second.
Quat FromAxes(const Vec3& a0, const Vec3& b0, const Vec3& a1, const Vec3& b1) noexcept {
  Eigen::Matrix3f from, to;
  from << a0, b0, a0.cross(b0);
  to << a1, b1, a1.cross(b1);
  return Quat(Eigen::Matrix3f(to * from.transpose())).normalized();
}

}  // namespace

const Limb& LimbOf(int index) noexcept { return kRows[static_cast<std::size_t>(index)]; }

LimbTurns Bend(const Limb& limb, const Vec3& root_m, const Vec3& target_m,
               const Vec3& pole) noexcept {
  const Vec3 wish = target_m - root_m;
  const float distance = wish.norm();
  const Vec3 along = distance > kTiny ? Vec3(wish / distance) : limb.along;
  // The legs' geometry shows it: along -Y, with the knee towards +Z, they bend about +X.
  const Vec3 hinge = Across(pole, along, along.unitOrthogonal()).cross(along);
  const Quat start = FromAxes(limb.along, limb.hinge, along, hinge);
  const float a = body::Offset(limb.lower).norm();
  const float b = body::Offset(limb.end).norm();
  const feet::TwoBones bones{root_m, root_m + a * along, root_m + (a + b) * along, hinge};
  const feet::TwoBoneTurns turns = feet::ReachFor(bones, target_m);
  return {(turns.upper * start).normalized(), (turns.upper * turns.lower * start).normalized()};
}

Quat Aim(const Quat& rotation, const Vec3& offset, const Vec3& towards) noexcept {
  if (offset.norm() < kTiny || towards.norm() < kTiny) return rotation;
  return (body::ShortestTurn(rotation * offset, towards) * rotation).normalized();
}

}  // namespace styled::devices
