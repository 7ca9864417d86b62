#include "model/stylist/input_guard.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/units.h"

namespace styled::stylist {
namespace {

using support::kNaN;

rig::Skeleton TwoJoints() {
  return {{"root", "child"}, {-1, 0}, {rig::Vec3(0, 1, 0), rig::Vec3(0, 0.5F, 0)}};
}

struct InputGuardTest : testing::Test {
  rig::Skeleton skeleton = TwoJoints();
  InputGuard guard{skeleton};
  rig::RigPose in{skeleton}, source{skeleton};
  std::bitset<256> held;
  Options options;

  InputGuard::Jump Feed(double dt_s = 1.0 / 120) {
    guard.HoldBadJoints(in, source, held);
    return guard.JudgeJump(dt_s, 1.0F, options, source);
  }
};

TEST_F(InputGuardTest, AGoodPosePassesBitForBit) {
  in.rotations[1] = rig::Quat(0.8001F, 0.6F, 0, 0);  // length 1 up to a rig's rounding
  Feed();
  EXPECT_EQ(source.rotations[1].coeffs(), in.rotations[1].coeffs());
  EXPECT_NEAR(guard.clean().rotations[1].norm(), 1.0F, 1e-6F);
  EXPECT_TRUE(held.none());
}

TEST_F(InputGuardTest, ARotationThatIsNotOfLengthOneLeavesWithThatLength) {
  in.rotations[1] = rig::Quat(3, 0, 4, 0);
  Feed();
  EXPECT_TRUE(held.none());
  EXPECT_LT((source.rotations[1].coeffs() - rig::Quat(0.6F, 0, 0.8F, 0).coeffs()).norm(), 1e-6F);
}

TEST_F(InputGuardTest, ANotANumberIsHeldInItsJointAlone) {
  in.rotations[1] = rig::Quat(0.8F, 0.6F, 0, 0);
  Feed();
  in.rotations[0] = rig::Quat(0, 1, 0, 0);
  in.rotations[1].x() = kNaN;
  Feed();
  EXPECT_EQ(source.rotations[1].coeffs(), rig::Quat(0.8F, 0.6F, 0, 0).coeffs());
  EXPECT_EQ(source.rotations[0].coeffs(), in.rotations[0].coeffs());
  EXPECT_FALSE(held.test(0));
  EXPECT_TRUE(held.test(1));
}

TEST_F(InputGuardTest, ABadFirstFrameIsHeldAtRest) {
  in.rotations[1].coeffs().setZero();
  in.translations[0].y() = std::numeric_limits<float>::infinity();
  Feed();
  EXPECT_EQ(source.rotations[1].coeffs(), rig::Quat::Identity().coeffs());
  EXPECT_EQ(source.translations[0], skeleton.offsets[0]);
  EXPECT_EQ(held.count(), 2U);
}

TEST_F(InputGuardTest, AJumpOfMetresIsHeldThenAcceptedWhenItLasts) {
  Feed();
  in.translations[0].x() = 5;
  for (int i = 1; i < options.jump_accept_frames; ++i) {
    EXPECT_EQ(Feed(), InputGuard::Jump::kHeld) << i;
    EXPECT_EQ(source.translations[0].x(), 0);
  }
  EXPECT_EQ(Feed(), InputGuard::Jump::kAccepted);
  EXPECT_EQ(source.translations[0].x(), 5);
  EXPECT_EQ(Feed(), InputGuard::Jump::kNone);
}

TEST_F(InputGuardTest, ASingleOutlierIsForgotten) {
  Feed();
  for (int round = 0; round < 30; ++round) {
    in.translations[0].x() = 5;
    EXPECT_EQ(Feed(), InputGuard::Jump::kHeld);
    in.translations[0].x() = 0;
    EXPECT_EQ(Feed(), InputGuard::Jump::kNone);
  }
}

TEST_F(InputGuardTest, AFastRunIsNoJump) {
  for (int i = 0; i < 200; ++i) {
    in.translations[0].x() = 0.09F * static_cast<float>(i);  // 10.8 m/s
    EXPECT_EQ(Feed(), InputGuard::Jump::kNone);
  }
}

}  // namespace
}  // namespace styled::stylist
