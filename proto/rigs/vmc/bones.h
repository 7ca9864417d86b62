#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "model/base/realtime.h"

// The bones of VMC: UnityEngine.HumanBodyBones by their index, with the hierarchy of VRM's humanoid
// (vrm-c/vrm-specification). Pure; any thread. Pinned by tests/unit/vmc/bones_test.cpp.
namespace styled::vmc {

inline constexpr int kBoneCount = 55;

// The bones of the body by name. The fingers are 24 .. 38 (left) and 39 .. 53 (right): Proximal,
// Intermediate, Distal of Thumb, Index, Middle, Ring, Little.
enum BoneIndex : int {
  kHips,
  kLeftUpperLeg,
  kRightUpperLeg,
  kLeftLowerLeg,
  kRightLowerLeg,
  kLeftFoot,
  kRightFoot,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kLeftShoulder,
  kRightShoulder,
  kLeftUpperArm,
  kRightUpperArm,
  kLeftLowerArm,
  kRightLowerArm,
  kLeftHand,
  kRightHand,
  kLeftToes,
  kRightToes,
  kLeftEye,
  kRightEye,
  kJaw,
  kLeftThumbProximal,
  kLeftLittleDistal = 38,
  kRightThumbProximal = 39,
  kRightLittleDistal = 53,
  kUpperChest = 54
};

struct BoneRow {
  std::string_view name;
  int parent;  // -1: hips. If a model lacks the parent, use ParentAmong()
};
extern const std::array<BoneRow, kBoneCount> kBones;

// All bones, each after its parent.
extern const std::array<int, kBoneCount> kParentsFirst;

// A set of bones, one bit each.
using BoneSet = std::uint64_t;
constexpr BoneSet Bit(int bone) noexcept { return BoneSet{1} << static_cast<unsigned>(bone); }
constexpr bool Has(BoneSet set, int bone) noexcept { return (set & Bit(bone)) != 0; }
inline constexpr BoneSet kAllBones = Bit(kBoneCount) - 1;
inline constexpr BoneSet kFingers = Bit(kRightLittleDistal + 1) - Bit(kLeftThumbProximal);

// The bone named `name`, or -1: HumanBodyBones' own spelling, else any case. VRM 1.0 counts the
// thumb's bones from the hand on (thumbMetacarpal, thumbProximal, thumbDistal), Unity and VRM 0.x
// from the knuckle on (ThumbProximal, ThumbIntermediate, ThumbDistal). "thumbProximal" in lower
// case is therefore ambiguous and `vrm1` decides: set it once the session contained
// "thumbMetacarpal".
STYLED_REALTIME int FindBone(std::string_view name, bool vrm1) noexcept;
// Whether only VRM 1.0 has this name.
STYLED_REALTIME bool IsVrm1Name(std::string_view name) noexcept;

// The nearest ancestor in `set`, or -1.
STYLED_REALTIME int ParentAmong(BoneSet set, int bone) noexcept;

}  // namespace styled::vmc
