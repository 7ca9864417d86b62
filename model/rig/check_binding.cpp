#include "model/rig/check_binding.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/base/text.h"

namespace styled::rig {
namespace {

// The bones that are compared. Short ones are not: where a neck begins is each tool's own choice.
struct ComparedBone {
  int from, to;
};
constexpr std::array kBones = {
    ComparedBone{body::kHips, body::kHead},
    ComparedBone{body::kHips, body::kChest},
    ComparedBone{body::kChest, body::kNeck},
    ComparedBone{body::kLeftUpperArm, body::kLeftLowerArm},
    ComparedBone{body::kLeftLowerArm, body::kLeftHand},
    ComparedBone{body::kRightUpperArm, body::kRightLowerArm},
    ComparedBone{body::kRightLowerArm, body::kRightHand},
    ComparedBone{body::kLeftUpperLeg, body::kLeftLowerLeg},
    ComparedBone{body::kLeftLowerLeg, body::kLeftFoot},
    ComparedBone{body::kRightUpperLeg, body::kRightLowerLeg},
    ComparedBone{body::kRightLowerLeg, body::kRightFoot},
    ComparedBone{body::kLeftFoot, body::kLeftToes},
    ComparedBone{body::kRightFoot, body::kRightToes},
};

}  // namespace

std::vector<BoneAngle> CompareBones(const Binding& binding, std::span<const RigPose> poses) {
  const BindingSpec& spec = binding.spec();
  std::array<double, kBones.size()> sum_deg{};
  std::array<int, kBones.size()> count{};
  std::vector<Vec3> positions;
  std::vector<Quat> rotations;
  body::Pose pose;
  body::WorldPose humanoid;
  for (const RigPose& source : poses) {
    WorldTransforms(spec.skeleton, source, positions, rotations);
    binding.Bind(source, pose);
    body::ForwardKinematics(pose, humanoid);
    for (std::size_t i = 0; i < kBones.size(); ++i) {
      const auto from = static_cast<std::size_t>(kBones[i].from);
      const auto to = static_cast<std::size_t>(kBones[i].to);
      const int begin = spec.source_joint[from], end = spec.source_joint[to];
      if (begin < 0 || end < 0) continue;
      const Vec3 own = spec.canonical_from_source * (positions[static_cast<std::size_t>(end)] -
                                                     positions[static_cast<std::size_t>(begin)]);
      const Vec3 ours = humanoid.positions_m[to] - humanoid.positions_m[from];
      const float lengths = own.norm() * ours.norm();
      if (!(lengths > 0)) continue;
      sum_deg[i] += std::acos(std::clamp(own.dot(ours) / lengths, -1.0F, 1.0F)) * 57.29578F;
      ++count[i];
    }
  }
  std::vector<BoneAngle> bones;
  for (std::size_t i = 0; i < kBones.size(); ++i) {
    if (count[i] == 0) continue;
    const int begin = spec.source_joint[static_cast<std::size_t>(kBones[i].from)];
    bones.push_back({spec.skeleton.names[static_cast<std::size_t>(begin)],
                     static_cast<float>(sum_deg[i] / count[i])});
  }
  std::stable_sort(bones.begin(), bones.end(),
                   [](const BoneAngle& a, const BoneAngle& b) { return a.degrees > b.degrees; });
  return bones;
}

std::string WrongBone(const Binding& binding, std::span<const RigPose> poses) {
  const std::vector<BoneAngle> bones = CompareBones(binding, poses);
  if (bones.empty() || bones.front().degrees <= kUsualBone_deg) return "";
  constexpr std::size_t kShown = 64;  // bytes
  return "the bone at joint \"" + Printable(bones.front().joint, kShown) + "\" is " +
         std::to_string(std::lround(bones.front().degrees)) +
         " degrees off on the humanoid: this joint or one above it may be another's";
}

}  // namespace styled::rig
