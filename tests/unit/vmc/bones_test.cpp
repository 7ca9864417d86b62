#include "proto/rigs/vmc/bones.h"

#include <gtest/gtest.h>

#include <cctype>
#include <set>
#include <string>

namespace styled::vmc {
namespace {

std::string LowerFirst(std::string_view name) {
  std::string lower(name);
  lower[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(lower[0])));
  return lower;
}

TEST(Bones, NamesThatAreNoneAreNotFound) {
  for (const char* name : {"", "Hip", "Hipss", "LastBone", "Left Hand", "LeftThumb", "root",
                           "hips ", "UpperChestX", "\xFF\xFE"}) {
    EXPECT_EQ(FindBone(name, false), -1) << name;
    EXPECT_EQ(FindBone(name, true), -1) << name;
  }
}

TEST(Bones, AreFoundByUnitysSpellingWhateverTheSession) {
  for (int bone = 0; bone < kBoneCount; ++bone) {
    EXPECT_EQ(FindBone(kBones[bone].name, false), bone) << kBones[bone].name;
    EXPECT_EQ(FindBone(kBones[bone].name, true), bone) << kBones[bone].name;
  }
}

TEST(Bones, AreFoundInAnyCase) {
  for (int bone = 0; bone < kBoneCount; ++bone) {
    EXPECT_EQ(FindBone(LowerFirst(kBones[bone].name), false), bone) << kBones[bone].name;
    std::string upper(kBones[bone].name);
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    EXPECT_EQ(FindBone(upper, false), bone) << upper;
  }
}

TEST(Bones, ThumbsOfVrm1AreCountedFromTheHand) {
  EXPECT_TRUE(IsVrm1Name("leftThumbMetacarpal"));
  EXPECT_TRUE(IsVrm1Name("RightThumbMetacarpal"));
  EXPECT_FALSE(IsVrm1Name("leftThumbProximal"));
  EXPECT_EQ(FindBone("leftThumbMetacarpal", true), kLeftThumbProximal);
  EXPECT_EQ(FindBone("leftThumbProximal", true), kLeftThumbProximal + 1);
  EXPECT_EQ(FindBone("leftThumbDistal", true), kLeftThumbProximal + 2);
  EXPECT_EQ(FindBone("rightThumbMetacarpal", true), kRightThumbProximal);
  EXPECT_EQ(FindBone("rightThumbProximal", true), kRightThumbProximal + 1);
  EXPECT_EQ(FindBone("rightThumbDistal", true), kRightThumbProximal + 2);
  EXPECT_EQ(FindBone("leftIndexProximal", true), kLeftThumbProximal + 3);
}

// The index of UnityEngine.HumanBodyBones, at its marks.
TEST(Bones, StandInUnitysOrder) {
  EXPECT_EQ(kBones[0].name, "Hips");
  EXPECT_EQ(kBones[7].name, "Spine");
  EXPECT_EQ(kBones[10].name, "Head");
  EXPECT_EQ(kBones[17].name, "LeftHand");
  EXPECT_EQ(kBones[23].name, "Jaw");
  EXPECT_EQ(kBones[24].name, "LeftThumbProximal");
  EXPECT_EQ(kBones[38].name, "LeftLittleDistal");
  EXPECT_EQ(kBones[39].name, "RightThumbProximal");
  EXPECT_EQ(kBones[53].name, "RightLittleDistal");
  EXPECT_EQ(kBones[54].name, "UpperChest");
}

TEST(Bones, HangTogetherAsVrmSays) {
  const auto parent = [](std::string_view name) {
    return kBones[kBones[FindBone(name, false)].parent].name;
  };
  EXPECT_EQ(parent("Spine"), "Hips");
  EXPECT_EQ(parent("Chest"), "Spine");
  EXPECT_EQ(parent("UpperChest"), "Chest");
  EXPECT_EQ(parent("Neck"), "UpperChest");
  EXPECT_EQ(parent("LeftShoulder"), "UpperChest");
  EXPECT_EQ(parent("Head"), "Neck");
  EXPECT_EQ(parent("Jaw"), "Head");
  EXPECT_EQ(parent("RightEye"), "Head");
  EXPECT_EQ(parent("LeftToes"), "LeftFoot");
  // Sides stay apart; each finger is a chain of three on its hand.
  for (int bone = 0; bone < kBoneCount; ++bone) {
    const std::string name(kBones[bone].name);
    if (kBones[bone].parent < 0) continue;
    const std::string up(kBones[kBones[bone].parent].name);
    for (const std::string side : {"Left", "Right"}) {
      if (name.starts_with(side) && (up.starts_with("Left") || up.starts_with("Right"))) {
        EXPECT_TRUE(up.starts_with(side)) << name;
      }
      if (!name.starts_with(side) || bone < kLeftThumbProximal) continue;
      if (name.ends_with("Proximal")) {
        EXPECT_EQ(up, side + "Hand") << name;
      }
      if (name.ends_with("Intermediate")) {
        EXPECT_EQ(up, name.substr(0, name.size() - 12) + "Proximal");
      }
      if (name.ends_with("Distal")) {
        EXPECT_EQ(up, name.substr(0, name.size() - 6) + "Intermediate");
      }
    }
  }
}

TEST(Bones, InTheirOrderComeAfterTheirParents) {
  std::set<int> seen;
  for (const int bone : kParentsFirst) {
    if (kBones[bone].parent >= 0) {
      EXPECT_TRUE(seen.contains(kBones[bone].parent)) << bone;
    }
    seen.insert(bone);
  }
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(kBoneCount));
  EXPECT_EQ(kParentsFirst[0], kHips);
}

TEST(Bones, HangOnTheNearestAncestorThereIs) {
  EXPECT_EQ(ParentAmong(kAllBones, kNeck), kUpperChest);
  EXPECT_EQ(ParentAmong(kAllBones & ~Bit(kUpperChest), kNeck), kChest);
  EXPECT_EQ(ParentAmong(Bit(kHips) | Bit(kHead), kHead), kHips);
  EXPECT_EQ(ParentAmong(Bit(kHead), kHead), -1);
  EXPECT_EQ(ParentAmong(kAllBones, kHips), -1);
}

}  // namespace
}  // namespace styled::vmc
