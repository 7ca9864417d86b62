#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "model/base/hash.h"

namespace styled::body {

// The canonical humanoid: a 21-joint subset of VRM 1.0 that every rig is bound to before the
// network sees it. Right-handed, +Y up, +Z forward, +X the body's left; metres. The rest pose is a
// T-pose in which every joint's rotation is identity.
enum Joint : int {
  kHips,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kLeftShoulder,
  kLeftUpperArm,
  kLeftLowerArm,
  kLeftHand,
  kRightShoulder,
  kRightUpperArm,
  kRightLowerArm,
  kRightHand,
  kLeftUpperLeg,
  kLeftLowerLeg,
  kLeftFoot,
  kLeftToes,
  kRightUpperLeg,
  kRightLowerLeg,
  kRightFoot,
  kRightToes,
  kJointCount
};

// One row of the table: VRM 1.0 bone name, parent (-1 for the root; parents precede children) and
// the offset from the parent at rest in metres. The root's offset is its rest position: hips
// height.
struct JointRow {
  std::string_view name;
  int parent;
  float x_m, y_m, z_m;
};

inline constexpr std::array<JointRow, kJointCount> kHumanoid{{
    {"hips", -1, 0.0F, 0.98F, 0.0F},
    {"spine", kHips, 0.0F, 0.13F, 0.0F},
    {"chest", kSpine, 0.0F, 0.11F, 0.0F},
    {"neck", kChest, 0.0F, 0.19F, 0.0F},
    {"head", kNeck, 0.0F, 0.08F, 0.01F},
    {"leftShoulder", kChest, 0.05F, 0.15F, 0.0F},
    {"leftUpperArm", kLeftShoulder, 0.10F, 0.0F, 0.0F},
    {"leftLowerArm", kLeftUpperArm, 0.27F, 0.0F, 0.0F},
    {"leftHand", kLeftLowerArm, 0.25F, 0.0F, 0.0F},
    {"rightShoulder", kChest, -0.05F, 0.15F, 0.0F},
    {"rightUpperArm", kRightShoulder, -0.10F, 0.0F, 0.0F},
    {"rightLowerArm", kRightUpperArm, -0.27F, 0.0F, 0.0F},
    {"rightHand", kRightLowerArm, -0.25F, 0.0F, 0.0F},
    {"leftUpperLeg", kHips, 0.09F, -0.05F, 0.0F},
    {"leftLowerLeg", kLeftUpperLeg, 0.0F, -0.42F, 0.0F},
    {"leftFoot", kLeftLowerLeg, 0.0F, -0.42F, 0.0F},
    {"leftToes", kLeftFoot, 0.0F, -0.07F, 0.13F},
    {"rightUpperLeg", kHips, -0.09F, -0.05F, 0.0F},
    {"rightLowerLeg", kRightUpperLeg, 0.0F, -0.42F, 0.0F},
    {"rightFoot", kRightLowerLeg, 0.0F, -0.42F, 0.0F},
    {"rightToes", kRightFoot, 0.0F, -0.07F, 0.13F},
}};

// Vertical distance from the hips to the toes at rest, metres. A rig is scaled so that its own
// distance becomes this one.
inline constexpr float kHipsAboveToes_m = 0.96F;

// The joint that corresponds to `joint` when left and right are swapped.
constexpr int MirrorJoint(int joint) {
  if (joint >= kLeftShoulder && joint <= kLeftHand) return joint + 4;
  if (joint >= kRightShoulder && joint <= kRightHand) return joint - 4;
  if (joint >= kLeftUpperLeg && joint <= kLeftToes) return joint + 4;
  if (joint >= kRightUpperLeg) return joint - 4;
  return joint;
}

// FNV-1a (64 bit) over names, parents and offsets in micrometres. Weights and frames carry it; a
// loader refuses weights that were made for another humanoid.
constexpr std::uint64_t HumanoidHash() {
  Fnv1a hash;
  const auto micrometres = [](float metres) {
    return static_cast<std::int64_t>(static_cast<double>(metres) * 1e6 + (metres < 0 ? -0.5 : 0.5));
  };
  for (const JointRow& row : kHumanoid) {
    hash.Text(row.name);
    hash.Byte(0);
    hash.Number(row.parent);
    hash.Number(micrometres(row.x_m));
    hash.Number(micrometres(row.y_m));
    hash.Number(micrometres(row.z_m));
  }
  return hash.value();
}

}  // namespace styled::body
