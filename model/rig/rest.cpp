// RestBySwing: finds a rig's T-pose if its files do not contain one.
#include <cmath>

#include "model/rig/binding.h"

namespace styled::rig {
namespace {

using body::kHumanoid;
using body::kJointCount;

// The next joint along the chain that a bone points to; -1 at the ends of the body.
constexpr std::array<int, kJointCount> kBoneEnd = [] {
  std::array<int, kJointCount> end{};
  end.fill(-1);
  // From the last child to the first, so that the spine overrides shoulders and legs.
  for (int joint = kJointCount - 1; joint > 0; --joint) end[kHumanoid[joint].parent] = joint;
  return end;
}();
static_assert(kBoneEnd[body::kHips] == body::kSpine && kBoneEnd[body::kChest] == body::kNeck);

// The standing pose by canonical joint, in canonical axes and source units.
struct Standing {
  std::array<bool, kJointCount> mapped{};
  std::array<Vec3, kJointCount> positions;
  float smallest_bone = 0;     // a shorter bone has no reliable direction
  float smallest_collars = 0;  // nor have collars that are nearer: 2 cm on an adult
};

// The direction of the bone that begins at `joint`, in the standing pose and in the T-pose.
struct BoneDirections {
  bool found = false;
  Vec3 standing, rest;
};
BoneDirections FindBone(const Standing& pose, int joint) {
  Vec3 rest = Vec3::Zero();
  for (int end = kBoneEnd[joint]; end >= 0; end = kBoneEnd[end]) {
    rest += body::Offset(end);
    if (!pose.mapped[end]) continue;
    const Vec3 bone = pose.positions[end] - pose.positions[joint];
    if (bone.norm() > pose.smallest_bone) return {true, bone.normalized(), rest.normalized()};
  }
  return {};
}

// The direction from the right joint of a pair to the left one; zero if either is missing, or they
// are nearer than `least`.
Vec3 Across(const Standing& pose, body::Joint left, body::Joint right, float least) {
  if (!pose.mapped[left] || !pose.mapped[right]) return Vec3::Zero();
  const Vec3 across = pose.positions[left] - pose.positions[right];
  return across.norm() > least ? Vec3(across.normalized()) : Vec3(Vec3::Zero());
}

// The direction across the shoulders, of collars, otherwise of upper arms: the first that runs
// beside that of the hips. Collars may begin a millimetre apart on the spine, in any direction.
Vec3 AcrossChest(const Standing& pose) {
  constexpr float kLeastCosine = 0.7F;  // 45 degrees: a trunk that stands is twisted less
  const Vec3 hips = Across(pose, body::kLeftUpperLeg, body::kRightUpperLeg, pose.smallest_bone);
  for (const auto& [left, right] : {std::pair{body::kLeftShoulder, body::kRightShoulder},
                                    std::pair{body::kLeftUpperArm, body::kRightUpperArm}}) {
    Vec3 across = Across(pose, left, right, pose.smallest_collars);
    if (!across.isZero() && (hips.isZero() || across.dot(hips) > kLeastCosine)) return across;
  }
  return Vec3::Zero();
}

// The rotation that takes `left` to +X and the plane of `left` and `up` to that of +X and +Y.
Quat SwingTwoAxes(const Vec3& left, const Vec3& up) {
  Eigen::Matrix3f axes;  // rows: where +X, +Y and +Z come from
  axes.row(0) = left;
  axes.row(1) = (up - left * left.dot(up)).normalized();
  axes.row(2) = left.cross(Vec3(axes.row(1).transpose()));
  return Quat(axes).normalized();
}

// The turn about the vertical that makes `forward` face +Z.
Quat FaceForward(const Vec3& forward) {
  const float yaw_rad = std::atan2(forward.x(), forward.z());
  return Quat(Eigen::AngleAxisf(-yaw_rad, Vec3::UnitY()));
}

Quat Swing(const Standing& pose, int joint, const Quat& parent_swing, const Quat& hips_swing) {
  const BoneDirections bone = FindBone(pose, joint);
  // The head is upright already: only its heading is corrected, to that of the hips.
  if (joint == body::kHead) return FaceForward(hips_swing.conjugate() * Vec3::UnitZ());
  if (!bone.found) return parent_swing;
  if (joint == body::kLeftFoot || joint == body::kRightFoot) return FaceForward(bone.standing);
  Vec3 left = Vec3::Zero();
  if (joint == body::kHips) {
    left = Across(pose, body::kLeftUpperLeg, body::kRightUpperLeg, pose.smallest_bone);
  }
  if (joint == body::kChest) left = AcrossChest(pose);
  if (!left.isZero()) return SwingTwoAxes(left, bone.standing);
  // The shortest arc that is left after the parent's swing.
  return body::ShortestTurn(parent_swing * bone.standing, bone.rest) * parent_swing;
}

}  // namespace

std::vector<Quat> RestBySwing(const Skeleton& skeleton,
                              const std::array<int, body::kJointCount>& source_joint,
                              const RigPose& standing, const Quat& canonical_from_source) {
  std::vector<Vec3> positions;
  std::vector<Quat> rest;
  WorldTransforms(skeleton, standing, positions, rest);

  Standing pose;
  for (int c = 0; c < kJointCount; ++c) {
    pose.mapped[c] = source_joint[c] >= 0;
    if (pose.mapped[c]) pose.positions[c] = canonical_from_source * positions[source_joint[c]];
  }
  if (pose.mapped[body::kHips] && pose.mapped[body::kLeftUpperLeg] &&
      pose.mapped[body::kLeftLowerLeg]) {
    const float thigh =
        (pose.positions[body::kLeftLowerLeg] - pose.positions[body::kLeftUpperLeg]).norm();
    pose.smallest_bone = 1e-3F * thigh;
    pose.smallest_collars = 0.05F * thigh;
  }

  std::array<Quat, kJointCount> swing;
  for (int c = 0; c < kJointCount; ++c) {
    const int parent = kHumanoid[c].parent;
    const Quat inherited = parent < 0 ? Quat::Identity() : swing[parent];
    swing[c] = pose.mapped[c] ? Swing(pose, c, inherited, swing[body::kHips]) : inherited;
  }

  // Every source joint gets the swing of the nearest mapped joint above it.
  std::vector<int> owner(skeleton.joint_count(), -1);
  for (int c = 0; c < kJointCount; ++c) {
    if (source_joint[c] >= 0) owner[source_joint[c]] = c;
  }
  for (int joint = 0; joint < skeleton.joint_count(); ++joint) {
    if (owner[joint] < 0 && joint > 0) owner[joint] = owner[skeleton.parents[joint]];
    if (owner[joint] < 0) continue;
    const Quat source_swing =
        canonical_from_source.conjugate() * swing[owner[joint]] * canonical_from_source;
    rest[joint] = (source_swing * rest[joint]).normalized();
  }
  return rest;
}

}  // namespace styled::rig
