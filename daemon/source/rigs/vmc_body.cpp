#include "daemon/source/rigs/vmc_body.h"

#include <algorithm>
#include <cmath>

#include "model/body/pose.h"
#include "model/rig/hands.h"
#include "proto/rigs/types.h"

namespace styled::source {
namespace {

using rig::Vec3;

// Positions of the bones in the canonical humanoid's T-pose.
std::array<Vec3, vmc::kBoneCount> CanonicalPositions() {
  std::array<Vec3, vmc::kBoneCount> at;
  body::WorldPose world;
  body::ForwardKinematics(body::Pose(), world);
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    const int bone = vmc::FindBone(body::kHumanoid[j].name, false);
    at[static_cast<std::size_t>(bone)] = world.positions_m[j];
  }
  at[vmc::kUpperChest] = 0.5F * (at[vmc::kChest] + at[vmc::kNeck]);
  at[vmc::kLeftEye] = at[vmc::kHead] + Vec3(0.03F, 0.06F, 0.08F);
  at[vmc::kRightEye] = at[vmc::kHead] + Vec3(-0.03F, 0.06F, 0.08F);
  at[vmc::kJaw] = at[vmc::kHead] + Vec3(0, 0.01F, 0.03F);
  for (int t = 0; t < rig::kTailLeftEye; ++t) {  // in the order of Unity's fingers
    const int before = rig::TailBefore(t);
    const int parent = before >= 0 ? vmc::kLeftThumbProximal + before
                                   : (t < rig::kTailRightThumb ? vmc::kLeftHand : vmc::kRightHand);
    at[static_cast<std::size_t>(vmc::kLeftThumbProximal + t)] =
        at[static_cast<std::size_t>(parent)] + rig::FingerOffset_m(t);
  }
  return at;
}

bool AllZero(vmc::BoneSet bones, const BonePositions& positions) {
  for (int bone = vmc::kHips + 1; bone < vmc::kBoneCount; ++bone) {
    if (!vmc::Has(bones, bone)) continue;
    for (const float value : positions[static_cast<std::size_t>(bone)]) {
      if (std::abs(value) > 1e-6F) return false;
    }
  }
  return true;
}

// The names of up to `most` bones: "Head, LeftHand and 12 more".
std::string Names(vmc::BoneSet bones, int most) {
  std::string names;
  int count = 0;
  for (int bone = 0; bone < vmc::kBoneCount; ++bone) {
    if (!vmc::Has(bones, bone) || ++count > most) continue;
    names +=
        (names.empty() ? "" : ", ") + std::string(vmc::kBones[static_cast<std::size_t>(bone)].name);
  }
  return count > most ? names + " and " + std::to_string(count - most) + " more" : names;
}

// The hips' height above the lowest bone in the T-pose.
float HipsHeight_m(const rig::Skeleton& skeleton) {
  float lowest_m = 0;
  std::vector<Vec3> positions(skeleton.offsets);
  for (std::size_t j = 1; j < positions.size(); ++j) {
    positions[j] += positions[static_cast<std::size_t>(skeleton.parents[j])];
    lowest_m = std::min(lowest_m, positions[j].y());
  }
  return -lowest_m;
}

}  // namespace

vmc::BoneSet CanonicalBones() {
  vmc::BoneSet bones = 0;
  for (const auto& row : body::kHumanoid) bones |= vmc::Bit(vmc::FindBone(row.name, false));
  return bones;
}

vmc::BoneSet RequiredBones() {
  vmc::BoneSet bones = CanonicalBones();
  for (const int bone : {vmc::kChest, vmc::kNeck, vmc::kLeftShoulder, vmc::kRightShoulder,
                         vmc::kLeftToes, vmc::kRightToes}) {
    bones &= ~vmc::Bit(bone);
  }
  return bones;
}

vmc::BoneSet BindableBones() {
  vmc::BoneSet bones = RequiredBones();
  for (const int bone :
       {vmc::kSpine, vmc::kLeftHand, vmc::kRightHand, vmc::kLeftFoot, vmc::kRightFoot}) {
    bones &= ~vmc::Bit(bone);
  }
  return bones;
}

std::string WhyNoPerformer(vmc::BoneSet bones) {
  constexpr vmc::BoneSet kLegs = vmc::Bit(vmc::kLeftUpperLeg) | vmc::Bit(vmc::kRightUpperLeg) |
                                 vmc::Bit(vmc::kLeftLowerLeg) | vmc::Bit(vmc::kRightLowerLeg);
  constexpr vmc::BoneSet kArms = vmc::Bit(vmc::kLeftUpperArm) | vmc::Bit(vmc::kRightUpperArm) |
                                 vmc::Bit(vmc::kLeftLowerArm) | vmc::Bit(vmc::kRightLowerArm);
  constexpr vmc::BoneSet kOfHands =
      vmc::kFingers | vmc::Bit(vmc::kLeftHand) | vmc::Bit(vmc::kRightHand);
  constexpr int kMostFound = 8;
  std::string why = (bones & kLegs) == 0   ? "VMC sends no leg bones: found "
                    : (bones & kArms) == 0 ? "VMC sends no arm bones: found "
                                           : "VMC sends not all bones of a body: found ";
  why += Names(bones, kMostFound) + ", missing " +
         Names(BindableBones() & ~bones, vmc::kBoneCount) +
         ", expected a whole body: let the application send all bones of its avatar";
  if ((bones & vmc::kFingers) != 0 && (bones & ~kOfHands) == 0) {
    why += R"(, or give its fingers to a performer by merge_into and parts = ["fingers"])";
  }
  return why;
}

rig::RigBody MakeVmcBody(vmc::BoneSet bones, const BonePositions& positions) {
  static const auto kCanonical = CanonicalPositions();
  const bool ours = AllZero(bones, positions);
  rig::RigBody body;
  body.metres_per_unit = 1.0F;
  body.dialect = rigs::kVmc.dialect;
  rig::Skeleton& skeleton = body.skeleton;
  std::array<int, vmc::kBoneCount> joint_of{};
  for (const int bone : vmc::kParentsFirst) {
    if (!vmc::Has(bones, bone)) continue;
    const auto at = static_cast<std::size_t>(bone);
    const int parent = vmc::ParentAmong(bones, bone);
    Vec3 offset(-positions[at][0], positions[at][1], positions[at][2]);
    if (ours && parent >= 0) offset = kCanonical[at] - kCanonical[static_cast<std::size_t>(parent)];
    if (parent < 0) offset.setZero();
    joint_of[at] = skeleton.joint_count();
    skeleton.names.emplace_back(vmc::kBones[at].name);
    const bool first = skeleton.parents.empty();
    skeleton.parents.push_back(first        ? -1
                               : parent < 0 ? 0
                                            : joint_of[static_cast<std::size_t>(parent)]);
    skeleton.offsets.push_back(offset);
  }
  skeleton.offsets.front().y() = HipsHeight_m(skeleton);
  return body;
}

}  // namespace styled::source
