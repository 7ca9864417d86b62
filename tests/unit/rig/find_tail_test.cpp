#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "model/rig/tail.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

// The humanoid with five fingers at each hand: thumb, index, middle, ring, little; each of `joints`
// joints, named by `name`(finger, joint, left). With `palm` a first joint lies in the palm, but not
// the thumb's.
template <typename Name>
Skeleton WithHands(const Name& name, int joints, bool palm = false) {
  Skeleton skeleton = HumanoidSkeleton();
  for (const bool left : {true, false}) {
    const float x = left ? 1.0F : -1.0F;
    for (int finger = 0; finger < kFingersPerHand; ++finger) {
      int parent = left ? body::kLeftHand : body::kRightHand;
      for (int joint = 0; joint < joints; ++joint) {
        skeleton.names.push_back(name(finger, joint, left));
        skeleton.parents.push_back(parent);
        const float across_m = 0.04F - 0.02F * static_cast<float>(finger);
        const bool in_palm = palm && finger > 0;
        const float along_m = joint == 0              ? (finger == 0 || in_palm ? 0.025F : 0.09F)
                              : joint == 1 && in_palm ? 0.07F
                                                      : 0.03F;
        skeleton.offsets.emplace_back(x * along_m, 0, joint == 0 ? across_m : 0);
        parent = skeleton.joint_count() - 1;
      }
    }
  }
  return skeleton;
}
std::array<int, kJointCount> Own() {
  std::array<int, kJointCount> joints;
  for (int c = 0; c < kJointCount; ++c) joints[static_cast<std::size_t>(c)] = c;
  return joints;
}
// The joint that finger and place should have.
int Expected(bool left, int finger, int place, int joints) {
  return kJointCount + ((left ? 0 : kFingersPerHand) + finger) * joints + place;
}

void ExpectFingers(const Skeleton& skeleton, int joints, bool palm, const std::string& what) {
  const TailMap map = FindTail(skeleton, Own());
  for (const bool left : {true, false}) {
    for (int finger = 0; finger < kFingersPerHand; ++finger) {
      for (int place = 0; place < kFingerJoints; ++place) {
        const int tail = (left ? kTailLeftThumb : kTailRightThumb) + kFingerJoints * finger + place;
        EXPECT_EQ(map[static_cast<std::size_t>(tail)],
                  Expected(left, finger, place + (palm && finger > 0 ? 1 : 0), joints))
            << what << ": " << kTailNames[static_cast<std::size_t>(tail)];
      }
    }
  }
}

TEST(FindTail, FingersByAnyWordInTheirNames) {
  const std::vector<std::vector<std::string>> words = {
      {"thumb", "f_index", "f_middle", "f_ring", "f_pinky"},
      {"Thumb", "IndexFinger", "MiddleFinger", "RingFinger", "LittleFinger"},
      {"親指", "人指", "中指", "薬指", "小指"},
  };
  for (const auto& word : words) {
    ExpectFingers(WithHands(
                      [&](int finger, int joint, bool left) {
                        return "DEF-" + word[static_cast<std::size_t>(finger)] + ".0" +
                               std::to_string(joint + 1) + (left ? ".L_07" : ".R_08");
                      },
                      3),
                  3, false, word[1]);
  }
}

TEST(FindTail, FingersWithoutNamesByTheirOrderAcrossThePalm) {
  const auto name = [](int finger, int joint, bool left) {
    return "b" + std::to_string((left ? 100 : 200) + 10 * finger + joint);
  };
  ExpectFingers(WithHands(name, 3), 3, false, "three joints");
  ExpectFingers(WithHands(name, 4), 4, false, "three joints and a tip");
}

TEST(FindTail, AJointInThePalmIsPassed) {
  const std::vector<std::string> word = {"thumb", "index", "middle", "ring", "pinky"};
  ExpectFingers(WithHands(
                    [&](int finger, int joint, bool left) {
                      return word[static_cast<std::size_t>(finger)] + "x" + std::to_string(joint) +
                             (left ? "left" : "right");
                    },
                    4, true),
                4, true, "metacarpals");
}

TEST(FindTail, WhatAHandHoldsIsNoFinger) {
  Skeleton skeleton = HumanoidSkeleton();
  skeleton.names.emplace_back("sword");
  skeleton.parents.push_back(body::kRightHand);
  skeleton.offsets.emplace_back(0, 0, 0.1F);
  skeleton.names.emplace_back("blade");
  skeleton.parents.push_back(kJointCount);
  skeleton.offsets.emplace_back(0, 0, 0.5F);
  EXPECT_EQ(FindTail(skeleton, Own()), NoTail());
}

}  // namespace
}  // namespace styled::rig
