#include "proto/rigs/vmc/bones.h"

#include <algorithm>

namespace styled::vmc {
namespace {

constexpr int kThumb = kLeftThumbProximal;

constexpr std::array<BoneRow, kBoneCount> kRows{{
    {"Hips", -1},
    {"LeftUpperLeg", kHips},
    {"RightUpperLeg", kHips},
    {"LeftLowerLeg", kLeftUpperLeg},
    {"RightLowerLeg", kRightUpperLeg},
    {"LeftFoot", kLeftLowerLeg},
    {"RightFoot", kRightLowerLeg},
    {"Spine", kHips},
    {"Chest", kSpine},
    {"Neck", kUpperChest},
    {"Head", kNeck},
    {"LeftShoulder", kUpperChest},
    {"RightShoulder", kUpperChest},
    {"LeftUpperArm", kLeftShoulder},
    {"RightUpperArm", kRightShoulder},
    {"LeftLowerArm", kLeftUpperArm},
    {"RightLowerArm", kRightUpperArm},
    {"LeftHand", kLeftLowerArm},
    {"RightHand", kRightLowerArm},
    {"LeftToes", kLeftFoot},
    {"RightToes", kRightFoot},
    {"LeftEye", kHead},
    {"RightEye", kHead},
    {"Jaw", kHead},
    {"LeftThumbProximal", kLeftHand},
    {"LeftThumbIntermediate", kThumb},
    {"LeftThumbDistal", kThumb + 1},
    {"LeftIndexProximal", kLeftHand},
    {"LeftIndexIntermediate", kThumb + 3},
    {"LeftIndexDistal", kThumb + 4},
    {"LeftMiddleProximal", kLeftHand},
    {"LeftMiddleIntermediate", kThumb + 6},
    {"LeftMiddleDistal", kThumb + 7},
    {"LeftRingProximal", kLeftHand},
    {"LeftRingIntermediate", kThumb + 9},
    {"LeftRingDistal", kThumb + 10},
    {"LeftLittleProximal", kLeftHand},
    {"LeftLittleIntermediate", kThumb + 12},
    {"LeftLittleDistal", kThumb + 13},
    {"RightThumbProximal", kRightHand},
    {"RightThumbIntermediate", kThumb + 15},
    {"RightThumbDistal", kThumb + 16},
    {"RightIndexProximal", kRightHand},
    {"RightIndexIntermediate", kThumb + 18},
    {"RightIndexDistal", kThumb + 19},
    {"RightMiddleProximal", kRightHand},
    {"RightMiddleIntermediate", kThumb + 21},
    {"RightMiddleDistal", kThumb + 22},
    {"RightRingProximal", kRightHand},
    {"RightRingIntermediate", kThumb + 24},
    {"RightRingDistal", kThumb + 25},
    {"RightLittleProximal", kRightHand},
    {"RightLittleIntermediate", kThumb + 27},
    {"RightLittleDistal", kThumb + 28},
    {"UpperChest", kChest},
}};

constexpr char Lower(char c) noexcept {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

// Whether `a` sorts before `b`, ignoring case.
constexpr bool Before(std::string_view a, std::string_view b) noexcept {
  const std::size_t size = std::min(a.size(), b.size());
  for (std::size_t i = 0; i < size; ++i) {
    if (Lower(a[i]) != Lower(b[i])) return Lower(a[i]) < Lower(b[i]);
  }
  return a.size() < b.size();
}
constexpr bool Same(std::string_view a, std::string_view b) noexcept {
  return a.size() == b.size() && !Before(a, b) && !Before(b, a);
}

struct Named {
  std::string_view name;
  int bone;
};

constexpr auto MakeByName() {
  std::array<Named, kBoneCount> sorted;
  for (int bone = 0; bone < kBoneCount; ++bone) {
    sorted[static_cast<std::size_t>(bone)] = {kRows[static_cast<std::size_t>(bone)].name, bone};
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const Named& a, const Named& b) { return Before(a.name, b.name); });
  return sorted;
}
constexpr auto kByName = MakeByName();

constexpr auto MakeParentsFirst() {
  std::array<int, kBoneCount> order{};
  std::size_t count = 0;
  BoneSet done = 0;
  while (count < order.size()) {
    for (int bone = 0; bone < kBoneCount; ++bone) {
      const int parent = kRows[static_cast<std::size_t>(bone)].parent;
      if (Has(done, bone) || (parent >= 0 && !Has(done, parent))) continue;
      done |= Bit(bone);
      order[count++] = bone;
    }
  }
  return order;
}

}  // namespace

const std::array<BoneRow, kBoneCount> kBones = kRows;
const std::array<int, kBoneCount> kParentsFirst = MakeParentsFirst();

bool IsVrm1Name(std::string_view name) noexcept {
  return Same(name, "leftThumbMetacarpal") || Same(name, "rightThumbMetacarpal");
}

int FindBone(std::string_view name, bool vrm1) noexcept {
  const auto* const found = std::lower_bound(
      kByName.begin(), kByName.end(), name,
      [](const Named& row, std::string_view wanted) { return Before(row.name, wanted); });
  if (found != kByName.end() && Same(found->name, name)) {
    // In lower-case VRM 1.0 names, thumbProximal is Unity's next bone, ThumbIntermediate.
    const bool left = found->bone == kLeftThumbProximal;
    const bool right = found->bone == kRightThumbProximal;
    return vrm1 && (left || right) && name != found->name ? found->bone + 1 : found->bone;
  }
  if (Same(name, "leftThumbMetacarpal")) return kLeftThumbProximal;
  if (Same(name, "rightThumbMetacarpal")) return kRightThumbProximal;
  return -1;
}

int ParentAmong(BoneSet set, int bone) noexcept {
  int parent = kRows[static_cast<std::size_t>(bone)].parent;
  while (parent >= 0 && !Has(set, parent)) parent = kRows[static_cast<std::size_t>(parent)].parent;
  return parent;
}

}  // namespace styled::vmc
