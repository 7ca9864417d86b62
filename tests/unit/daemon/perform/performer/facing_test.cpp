#include "daemon/perform/performer/facing.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/body/heading.h"

namespace styled::pipeline {
namespace {

constexpr double kStep_s = 1.0 / 120;

// Walks `metres` at `speed_mps` towards `heading_rad`, looking `turned_rad` away from there.
void Walk(Facing& facing, body::Pose& pose, float metres, float speed_mps, float turned_rad,
          float heading_rad = 0.4F) {
  const body::Vec3 ahead(std::sin(heading_rad), 0, std::cos(heading_rad));
  pose.rotations[body::kHips] = body::Yaw(heading_rad + turned_rad);
  const int frames = static_cast<int>(metres / speed_mps / static_cast<float>(kStep_s));
  for (int i = 0; i < frames; ++i) {
    pose.hips_position_m += ahead * speed_mps * static_cast<float>(kStep_s);
    facing.Sample(pose, kStep_s);
  }
}

struct FacingTest : testing::Test {
  FacingTest() { pose.rotations.fill(body::Quat::Identity()); }
  Facing facing;
  body::Pose pose;
};

constexpr float kPi = 3.14159265F;

TEST_F(FacingTest, APerformerWhoWalksAheadIsNotSuspected) {
  Walk(facing, pose, 100, 1.2F, 0);
  EXPECT_FALSE(facing.backwards());
}

TEST_F(FacingTest, AFewStepsBackAreActing) {
  Walk(facing, pose, 6, 1.2F, 0);
  Walk(facing, pose, 4, 0.8F, kPi);
  EXPECT_FALSE(facing.backwards());
}

TEST_F(FacingTest, SidewaysStepsAreIgnored) {
  Walk(facing, pose, 100, 1.0F, kPi / 2);
  EXPECT_FALSE(facing.backwards());
}

TEST_F(FacingTest, SwayingAndJumpsAreNotWalking) {
  Walk(facing, pose, 50, 0.2F, kPi);
  Walk(facing, pose, 200, 30.0F, kPi);
  EXPECT_FALSE(facing.backwards());
}

TEST_F(FacingTest, APerformerWhoAlwaysWalksBackwardsIsSuspectedForAnyHeading) {
  for (const float heading : {0.0F, 1.0F, 2.5F, -3.0F}) {
    facing.Reset();
    Walk(facing, pose, 7, 1.2F, kPi, heading);
    EXPECT_TRUE(facing.backwards()) << heading;
  }
}

TEST_F(FacingTest, TheSuspicionEndsWithItsReason) {
  Walk(facing, pose, 20, 1.2F, kPi);
  ASSERT_TRUE(facing.backwards());
  Walk(facing, pose, 30, 1.2F, 0);
  EXPECT_FALSE(facing.backwards());
}

TEST_F(FacingTest, InvalidPosesAreNotCounted) {
  const float huge = 1e30F;
  for (int i = 0; i < 1000; ++i) {
    pose.hips_position_m = body::Vec3(i % 2 == 0 ? huge : -huge, 0, huge);
    facing.Sample(pose, i % 3 == 0 ? 1e9 : kStep_s);
  }
  EXPECT_FALSE(facing.backwards());
}

}  // namespace
}  // namespace styled::pipeline
