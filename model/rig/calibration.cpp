#include "model/rig/calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>

#include "model/rig/check_binding.h"

namespace styled::rig {
namespace {

using body::kHumanoid;
using body::kJointCount;
using JointMap = std::array<int, kJointCount>;

constexpr float kTolerance_deg = 30.0F;

Status RequireMapped(const JointMap& map, const std::string& who) {
  std::string missing;
  for (const int c : {body::kHips, body::kHead, body::kLeftUpperArm, body::kLeftLowerArm,
                      body::kRightUpperArm, body::kRightLowerArm, body::kLeftUpperLeg,
                      body::kLeftLowerLeg, body::kRightUpperLeg, body::kRightLowerLeg}) {
    if (map[static_cast<std::size_t>(c)] >= 0) continue;
    missing.append(" ").append(kHumanoid[static_cast<std::size_t>(c)].name);
  }
  if (missing.empty()) return Status::Ok();
  return Status::Error(who + ": found no joint named like" + missing);
}

Status Refuse(const std::string& who, const BoneAngle& worst, const std::string& expected) {
  return Status::Error(who + ": joint " + worst.joint + " stands " +
                       std::to_string(std::lround(worst.degrees)) + " degrees off " + expected +
                       ", expected at most " + std::to_string(std::lround(kTolerance_deg)));
}

// Positions of the joints of the standing pose, in source axes.
struct Stand {
  JointMap map;
  std::vector<Vec3> positions;
  Vec3 At(int c) const {
    return positions[static_cast<std::size_t>(map[static_cast<std::size_t>(c)])];
  }
  bool Has(int c) const { return map[static_cast<std::size_t>(c)] >= 0; }
};

Stand Look(const Skeleton& skeleton, const JointMap& map, const RigPose& pose) {
  Stand stand{map, {}};
  std::vector<Quat> rotations;
  WorldTransforms(skeleton, pose, stand.positions, rotations);
  return stand;
}

// The rotation from the source's axes to the canonical ones, with the performer looking along +Z.
// Empty if hips and head, or left and right, are at the same place.
std::optional<Quat> FindAxes(const Stand& stand) {
  const Vec3 spine = stand.At(body::kHead) - stand.At(body::kHips);
  Eigen::Index axis = 0;
  if (!(spine.cwiseAbs().maxCoeff(&axis) > 0)) return std::nullopt;
  Vec3 up = Vec3::Zero();
  up[axis] = spine[axis] < 0 ? -1.0F : 1.0F;
  // Left: the mean direction across hips and shoulders, made perpendicular to up.
  Vec3 left = (stand.At(body::kLeftUpperLeg) - stand.At(body::kRightUpperLeg)).normalized() +
              (stand.At(body::kLeftUpperArm) - stand.At(body::kRightUpperArm)).normalized();
  left -= up * left.dot(up);
  if (!(left.norm() > 1e-3F)) return std::nullopt;
  left.normalize();
  Eigen::Matrix3f axes;
  axes.row(0) = left;
  axes.row(1) = up;
  axes.row(2) = left.cross(up);
  return Quat(axes).normalized();
}

// In a left-handed skeleton the toes appear behind the ankles.
bool ToesPointBackward(const Stand& stand, const Quat& canonical_from_source) {
  float forward = 0;
  for (const auto& [foot, toes] : {std::pair{body::kLeftFoot, body::kLeftToes},
                                   std::pair{body::kRightFoot, body::kRightToes}}) {
    if (!stand.Has(foot) || !stand.Has(toes)) continue;
    forward += (canonical_from_source * (stand.At(toes) - stand.At(foot))).z();
  }
  return forward < 0;
}

std::vector<BoneAngle> Judge(const Skeleton& skeleton, const Stand& stand,
                             const Quat& canonical_from_source, std::optional<StandingPose> arms) {
  std::vector<BoneAngle> bones;
  const auto check = [&](int from, int to, const Vec3& expected) {
    if (!stand.Has(from) || !stand.Has(to)) return;
    const Vec3 bone = canonical_from_source * (stand.At(to) - stand.At(from));
    if (!(bone.norm() > 0)) return;
    const float cosine = std::clamp(bone.normalized().dot(expected), -1.0F, 1.0F);
    const auto joint = static_cast<std::size_t>(stand.map[static_cast<std::size_t>(from)]);
    bones.push_back({skeleton.names[joint], std::acos(cosine) * 57.29578F});
  };
  const Vec3 up = Vec3::UnitY();
  check(body::kHips, body::kHead, up);
  if (arms) {
    const Vec3 left_arm = arms == StandingPose::kT ? Vec3(Vec3::UnitX()) : Vec3(-up);
    const Vec3 right_arm = arms == StandingPose::kT ? Vec3(-Vec3::UnitX()) : Vec3(-up);
    check(body::kLeftUpperArm, body::kLeftLowerArm, left_arm);
    check(body::kLeftLowerArm, body::kLeftHand, left_arm);
    check(body::kRightUpperArm, body::kRightLowerArm, right_arm);
    check(body::kRightLowerArm, body::kRightHand, right_arm);
  }
  check(body::kLeftUpperLeg, body::kLeftLowerLeg, -up);
  check(body::kLeftLowerLeg, body::kLeftFoot, -up);
  check(body::kRightUpperLeg, body::kRightLowerLeg, -up);
  check(body::kRightLowerLeg, body::kRightFoot, -up);
  std::stable_sort(bones.begin(), bones.end(),
                   [](const BoneAngle& a, const BoneAngle& b) { return a.degrees > b.degrees; });
  return bones;
}

}  // namespace

Status CanCalibrate(const Skeleton& skeleton, const JointNames& given) {
  const auto map = MapJoints(skeleton, given);
  return map.ok() ? RequireMapped(map.value(), "calibrate") : map.status();
}

Status CanCalibrate(const JointMap& map) { return RequireMapped(map, "calibrate"); }

Result<Calibrated> Calibrate(const Skeleton& skeleton, const RigPose& standing, StandingPose pose,
                             const JointNames& given) {
  const auto mapped = MapJoints(skeleton, given);
  if (!mapped.ok()) return mapped.status();
  const JointMap& map = mapped.value();
  if (Status status = RequireMapped(map, "calibrate"); !status.ok()) return status;
  Skeleton seen = skeleton;
  RigPose stood = standing;
  Stand stand = Look(seen, map, stood);
  auto axes = FindAxes(stand);
  const bool mirrored = axes && ToesPointBackward(stand, *axes);
  if (mirrored) {
    for (Vec3& offset : seen.offsets) offset = Mirrored(offset);
    Mirror(stood);
    stand = Look(seen, map, stood);
    axes = FindAxes(stand);
  }
  if (!axes) {
    return Status::Error(
        "calibrate: found hips and head, or left and right, in one place, expected a performer who "
        "stands upright");
  }
  Calibrated result;
  result.bones = Judge(skeleton, stand, *axes, pose);
  const BoneAngle& worst = result.bones.front();
  if (!(worst.degrees <= kTolerance_deg)) {
    return Refuse("calibrate", worst, pose == StandingPose::kT ? "a T-pose" : "an N-pose");
  }
  result.mirrored = mirrored;
  result.spec.rest_rotations = RestBySwing(seen, map, stood, *axes);
  result.spec.skeleton = std::move(seen);
  result.spec.source_joint = map;
  result.spec.canonical_from_source = *axes;
  const auto binding = Binding::Make(result.spec);
  if (!binding.ok()) return binding.status();
  if (const std::string wrong = WrongBone(binding.value(), std::span(&stood, 1)); !wrong.empty()) {
    return Status::Error("calibrate: " + wrong);
  }
  return result;
}

Result<Binding> BindStanding(const Skeleton& skeleton, const JointMap& source_joint,
                             const RigPose& standing, bool t_pose, float* worst_deg) {
  if (Status status = RequireMapped(source_joint, "avatar"); !status.ok()) return status;
  const Stand stand = Look(skeleton, source_joint, standing);
  const auto axes = FindAxes(stand);
  if (!axes) {
    return Status::Error(
        "avatar: found hips and head, or left and right, in one place, expected one that stands");
  }
  if (ToesPointBackward(stand, *axes)) {
    return Status::Error(
        "avatar: its toes point backward: left and right are exchanged by the names, or the axes "
        "are "
        "left-handed");
  }
  const auto bones =
      Judge(skeleton, stand, *axes, t_pose ? std::optional(StandingPose::kT) : std::nullopt);
  if (!(bones.front().degrees <= kTolerance_deg)) {
    return Refuse("avatar", bones.front(), t_pose ? "a T-pose" : "standing upright");
  }
  if (worst_deg != nullptr) *worst_deg = bones.front().degrees;
  BindingSpec spec{skeleton, source_joint, {}, *axes};
  if (t_pose) {
    std::vector<Vec3> positions;
    WorldTransforms(skeleton, standing, positions, spec.rest_rotations);
  } else {
    spec.rest_rotations = RestBySwing(skeleton, source_joint, standing, *axes);
  }
  return Binding::Make(std::move(spec));
}

}  // namespace styled::rig
