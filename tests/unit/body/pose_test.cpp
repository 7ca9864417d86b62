#include "model/body/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/body/random_pose.h"

namespace styled::body {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

TEST(ForwardKinematics, AtRestEveryJointStandsWhereTheOffsetsAddUp) {
  WorldPose world;
  ForwardKinematics(Pose(), world);
  for (int joint = 0; joint < kJointCount; ++joint) {
    Vec3 expected = Vec3::Zero();
    for (int up = joint; up >= 0; up = kHumanoid[up].parent) expected += Offset(up);
    EXPECT_TRUE(world.positions_m[joint].isApprox(expected, 1e-6F)) << kHumanoid[joint].name;
    EXPECT_LT(Angle_rad(world.rotations[joint], Quat::Identity()), 1e-6);
  }
}

TEST(ForwardKinematics, TurningTheLeftElbowMovesTheLeftHandAlone) {
  Pose pose;
  WorldPose rest, bent;
  ForwardKinematics(pose, rest);
  pose.rotations[kLeftLowerArm] = Quat(Eigen::AngleAxisf(-kPi / 2, Vec3::UnitY()));
  ForwardKinematics(pose, bent);
  for (int joint = 0; joint < kJointCount; ++joint) {
    if (joint == kLeftHand) continue;
    EXPECT_TRUE(bent.positions_m[joint].isApprox(rest.positions_m[joint])) << joint;
  }
  const Vec3 hand = bent.positions_m[kLeftHand] - bent.positions_m[kLeftLowerArm];
  EXPECT_NEAR((hand - Vec3(0, 0, 0.25F)).norm(), 0, 1e-6) << "forward";
}

TEST(ForwardKinematics, MovingAndTurningTheHipsMovesTheWholeBodyRigidly) {
  Random random(1);
  for (int round = 0; round < 100; ++round) {
    const Pose pose = random.AnyPose();
    const Quat turn = random.Turn(kPi);
    const Vec3 shift = random.Vector(5);
    Pose moved = pose;
    moved.hips_position_m = turn * pose.hips_position_m + shift;
    moved.rotations[kHips] = turn * pose.rotations[kHips];
    WorldPose a, b;
    ForwardKinematics(pose, a);
    ForwardKinematics(moved, b);
    for (int joint = 0; joint < kJointCount; ++joint) {
      EXPECT_LT((turn * a.positions_m[joint] + shift - b.positions_m[joint]).norm(), 3e-5);
      EXPECT_LT(Angle_rad(turn * a.rotations[joint], b.rotations[joint]), 1e-5);
    }
  }
}

TEST(Interpolate, GivesBothEndsBack) {
  Random random(2);
  const Pose a = random.AnyPose(), b = random.AnyPose();
  Pose out;
  Interpolate(a, b, 0, out);
  EXPECT_TRUE(out.hips_position_m.isApprox(a.hips_position_m));
  for (int j = 0; j < kJointCount; ++j)
    EXPECT_LT(Angle_rad(out.rotations[j], a.rotations[j]), 1e-5);
  Interpolate(a, b, 1, out);
  EXPECT_TRUE(out.hips_position_m.isApprox(b.hips_position_m));
  for (int j = 0; j < kJointCount; ++j)
    EXPECT_LT(Angle_rad(out.rotations[j], b.rotations[j]), 1e-5);
}

TEST(Interpolate, TakesTheShorterArcWhateverTheSigns) {
  Pose a, b, out;
  b.rotations[kHead] = Quat(Eigen::AngleAxisf(0.4F, Vec3::UnitX()));
  b.rotations[kHead].coeffs() *= -1;
  Interpolate(a, b, 0.5F, out);
  EXPECT_LT(Angle_rad(out.rotations[kHead], Quat(Eigen::AngleAxisf(0.2F, Vec3::UnitX()))), 1e-5);
}

TEST(Mirror, TwiceGivesThePoseBackInPlaceToo) {
  Random random(3);
  for (int round = 0; round < 50; ++round) {
    const Pose pose = random.AnyPose();
    Pose twice;
    Mirror(pose, twice);
    Mirror(twice, twice);
    EXPECT_TRUE(twice.hips_position_m.isApprox(pose.hips_position_m));
    for (int joint = 0; joint < kJointCount; ++joint) {
      EXPECT_LT(Angle_rad(twice.rotations[joint], pose.rotations[joint]), 1e-6);
    }
  }
}

TEST(Mirror, MirrorsEveryJointsPositionInTheWorld) {
  Random random(4);
  for (int round = 0; round < 50; ++round) {
    const Pose pose = random.AnyPose();
    Pose mirrored;
    Mirror(pose, mirrored);
    WorldPose a, b;
    ForwardKinematics(pose, a);
    ForwardKinematics(mirrored, b);
    for (int joint = 0; joint < kJointCount; ++joint) {
      const Vec3 expected = a.positions_m[joint].cwiseProduct(Vec3(-1, 1, 1));
      EXPECT_LT((b.positions_m[MirrorJoint(joint)] - expected).norm(), 2e-5);
    }
  }
}

TEST(LowestFoot, IsTheLowestOfFeetAndToesOnEitherSide) {
  Pose pose;
  WorldPose world;
  ForwardKinematics(pose, world);
  EXPECT_NEAR(LowestFoot_m(world), 0.02, 1e-6);
  for (int joint : {kLeftFoot, kLeftToes, kRightFoot, kRightToes}) {
    WorldPose lower = world;
    lower.positions_m[joint].y() = -0.5F;
    EXPECT_EQ(LowestFoot_m(lower), -0.5F) << kHumanoid[joint].name;
  }
}

TEST(LogAndExp, AreEachOthersInverseFromZeroToAHalfTurn) {
  Random random(5);
  for (float angle : {0.0F, 1e-9F, 1e-7F, 1e-6F, 2e-6F, 1e-4F, 0.1F, 1.0F, 2.0F, 3.0F, 3.14F}) {
    for (int round = 0; round < 20; ++round) {
      const Vec3 axis = random.Vector(1).normalized();
      const Vec3 back = Log(Exp(angle * axis));
      EXPECT_LT((back - angle * axis).norm(), 1e-6 + 1e-6 * angle) << angle;
    }
  }
}

TEST(LogAndExp, AgreeWithAxisAndAngle) {
  const Quat q = Exp(Vec3(0, 0.5F, 0));
  EXPECT_LT(Angle_rad(q, Quat(Eigen::AngleAxisf(0.5F, Vec3::UnitY()))), 1e-6);
}

TEST(Log, NearAnotherTurnGoesOnPastAHalfTurn) {
  Random random(7);
  for (int round = 0; round < 20; ++round) {
    const Vec3 axis = random.Vector(1).normalized();
    Vec3 last = Vec3::Zero();
    for (float angle = 0; angle < 4.5F; angle += 0.1F) {
      const Quat turn = Exp(angle * axis);
      const Vec3 v = LogNear(turn, last);
      EXPECT_LT((v - angle * axis).norm(), 1e-4) << angle;
      EXPECT_LT(Angle_rad(Exp(v), turn), 1e-4);
      last = v;
    }
    const Quat small = Exp(1.5F * axis);
    EXPECT_LT((LogNear(small, -4.0F * axis) - Log(small)).norm(), 1e-6);
  }
}

TEST(Log, IsTheSameForBothSignsOfARotation) {
  Random random(6);
  for (int round = 0; round < 50; ++round) {
    const Quat q = random.Turn(3.0F);
    Quat negative = q;
    negative.coeffs() *= -1;
    EXPECT_LT((Log(q) - Log(negative)).norm(), 1e-6);
    EXPECT_LE(Log(q).norm(), kPi + 1e-6F);
  }
}

}  // namespace
}  // namespace styled::body
