#include "model/rig/check_binding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

using testing::HasSubstr;

std::vector<RigPose> Poses(const Skeleton& skeleton) {
  Random random(5);
  std::vector<RigPose> poses(20, RigPose(skeleton));
  for (RigPose& pose : poses) {
    for (Quat& rotation : pose.rotations) rotation = random.Turn(0.5F);
  }
  return poses;
}

TEST(CheckBinding, ARightBindingHasNoWrongBone) {
  const Binding binding = Binding::Make(HumanoidSpec()).value();
  const auto bones = CompareBones(binding, Poses(binding.skeleton()));
  ASSERT_EQ(bones.size(), 13U);
  EXPECT_LT(bones.front().degrees, 0.1F);
  EXPECT_EQ(WrongBone(binding, Poses(binding.skeleton())), "");
}

TEST(CheckBinding, AChestTurnedByItsRestIsNamed) {
  BindingSpec spec = HumanoidSpec();
  spec.rest_rotations[body::kChest] = Quat(Eigen::AngleAxisf(1.57F, Vec3::UnitZ()));
  const Binding binding = Binding::Make(spec).value();
  EXPECT_THAT(WrongBone(binding, Poses(binding.skeleton())),
              HasSubstr("the bone at joint \"chest\" is 90 degrees off on the humanoid"));
}

TEST(CheckBinding, AnExchangedLegIsNamed) {
  BindingSpec spec = HumanoidSpec();
  std::swap(spec.source_joint[body::kLeftUpperLeg], spec.source_joint[body::kLeftUpperArm]);
  std::swap(spec.source_joint[body::kLeftLowerLeg], spec.source_joint[body::kLeftLowerArm]);
  const Binding binding = Binding::Make(spec).value();
  EXPECT_NE(WrongBone(binding, Poses(binding.skeleton())), "");
}

TEST(CheckBinding, BonesThatAreNotThereAreLeftOut) {
  BindingSpec spec = HumanoidSpec();
  for (const int c : {body::kSpine, body::kChest, body::kNeck, body::kLeftHand, body::kRightHand}) {
    spec.source_joint[static_cast<std::size_t>(c)] = -1;
  }
  const Binding binding = Binding::Make(spec).value();
  EXPECT_EQ(CompareBones(binding, Poses(binding.skeleton())).size(), 9U);
  EXPECT_TRUE(CompareBones(binding, {}).empty());
}

}  // namespace
}  // namespace styled::rig
