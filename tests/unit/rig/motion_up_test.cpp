#include "model/rig/motion_up.h"

#include <gtest/gtest.h>

#include "model/rig/dialects.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

// Poses of the humanoid near its T-pose, each turned by `turn` at the root.
std::vector<RigPose> Turned(const Quat& turn, int count = 20) {
  Random random(3);
  std::vector<RigPose> poses(static_cast<std::size_t>(count), RigPose(HumanoidSkeleton()));
  for (RigPose& pose : poses) {
    for (Quat& rotation : pose.rotations) rotation = random.Turn(0.1F);
    pose.translations[0] = turn * pose.translations[0];
    pose.rotations[0] = turn * pose.rotations[0];
  }
  return poses;
}

TEST(MotionUp, IsTheAxisAlongWhichTrunkAndLegsStand) {
  const Binding binding = BindDialect(HumanoidSkeleton()).value();
  EXPECT_LT((UpOf(binding) - Vec3::UnitY()).norm(), 1e-5F);
  EXPECT_FALSE(UpOfMotion(binding, Turned(Quat::Identity())));
  for (const Vec3 axis : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    const auto up = UpOfMotion(binding, Turned(Quat::FromTwoVectors(Vec3::UnitY(), axis)));
    ASSERT_TRUE(up);
    EXPECT_LT((*up - axis).norm(), 1e-5F);
  }
  EXPECT_FALSE(UpOfMotion(binding, {}));
}

TEST(MotionUp, StaysWhereThePerformerLiesForAWhileOnly) {
  const Binding binding = BindDialect(HumanoidSkeleton()).value();
  auto poses = Turned(Quat::Identity(), 10);
  const auto lying = Turned(Quat::FromTwoVectors(Vec3::UnitY(), Vec3::UnitZ()), 20);
  poses.insert(poses.end(), lying.begin(), lying.end());
  EXPECT_FALSE(UpOfMotion(binding, poses));
}

TEST(MotionUp, TheBindingStandsAlongIt) {
  const Binding binding = BindDialect(HumanoidSkeleton()).value();
  for (const Vec3 axis : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, -1, 0)}) {
    const auto turned = WithUp(binding, axis);
    ASSERT_TRUE(turned.ok()) << turned.status().message();
    EXPECT_LT((UpOf(turned.value()) - axis).norm(), 1e-5F);
    const bool down = axis.y() < 0;
    const Quat turn = down ? Quat(Eigen::AngleAxisf(3.14159265F, Vec3::UnitX()))
                           : Quat::FromTwoVectors(Vec3::UnitY(), axis);
    const auto upright = Turned(Quat::Identity()), poses = Turned(turn);
    body::Pose expected, found;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      binding.Bind(upright[i], expected);
      turned.value().Bind(poses[i], found);
      EXPECT_LT((found.hips_position_m - expected.hips_position_m).norm(), 1e-4F);
      for (int c = 0; c < kJointCount; ++c) {
        EXPECT_LT(Angle_rad(found.rotations[c], expected.rotations[c]), 1e-3F);
      }
    }
  }
}

}  // namespace
}  // namespace styled::rig
