#include "model/body/humanoid.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace styled::body {
namespace {

TEST(Humanoid, ParentsPrecedeTheirChildren) {
  EXPECT_EQ(kHumanoid[kHips].parent, -1);
  for (int joint = 1; joint < kJointCount; ++joint) {
    EXPECT_GE(kHumanoid[joint].parent, 0) << kHumanoid[joint].name;
    EXPECT_LT(kHumanoid[joint].parent, joint) << kHumanoid[joint].name;
  }
}

TEST(Humanoid, NamesAreUnique) {
  std::set<std::string_view> names;
  for (const JointRow& row : kHumanoid) EXPECT_TRUE(names.insert(row.name).second) << row.name;
}

TEST(Humanoid, MirroringAJointTwiceGivesItBack) {
  for (int joint = 0; joint < kJointCount; ++joint) {
    EXPECT_EQ(MirrorJoint(MirrorJoint(joint)), joint);
  }
}

TEST(Humanoid, MirrorJointSwapsLeftAndRightInNameParentAndOffset) {
  for (int joint = 0; joint < kJointCount; ++joint) {
    const JointRow& row = kHumanoid[joint];
    const JointRow& other = kHumanoid[MirrorJoint(joint)];
    std::string name(row.name);
    if (name.starts_with("left")) {
      name.replace(0, 4, "right");
    } else if (name.starts_with("right")) {
      name.replace(0, 5, "left");
    }
    EXPECT_EQ(other.name, name);
    EXPECT_EQ(other.parent, joint == kHips ? -1 : MirrorJoint(row.parent)) << name;
    EXPECT_EQ(other.x_m, -row.x_m) << name;
    EXPECT_EQ(other.y_m, row.y_m) << name;
    EXPECT_EQ(other.z_m, row.z_m) << name;
  }
}

TEST(Humanoid, HipsAboveToesIsTheSumOfTheLegsOffsets) {
  float height_m = 0;
  for (int joint = kLeftToes; joint != kHips; joint = kHumanoid[joint].parent) {
    height_m -= kHumanoid[joint].y_m;
  }
  EXPECT_NEAR(height_m, kHipsAboveToes_m, 1e-6);
}

// Shipped weights carry this number: a change of the table shows here first.
TEST(Humanoid, HashIsTheOneThatShippedWeightsCarry) {
  static_assert(HumanoidHash() != 0);
  EXPECT_EQ(HumanoidHash(), 11816682837846854121ULL);
}

}  // namespace
}  // namespace styled::body
