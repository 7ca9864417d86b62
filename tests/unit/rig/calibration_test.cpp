#include "model/rig/calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/rig/dialects.h"
#include "tests/unit/rig/rigs.h"

namespace styled::rig {
namespace {

constexpr float kDegrees = 57.29578F;

// The same body with arbitrary joint frames, its arms `lowered` in its zero pose, its axes rotated
// by `world` and, if asked, left-handed: a rig without documentation.
struct Unknown {
  Skeleton skeleton;
  std::array<Quat, kJointCount> rest;  // world, in T-pose, before `world`
  Quat world = Quat::Identity();
  bool left_handed = false;

  explicit Unknown(Random& random, const Quat& axes, bool mirror)
      : world(axes), left_handed(mirror) {
    for (Quat& rotation : rest) rotation = random.Turn(3.0F);
    for (int c = 0; c < kJointCount; ++c) {
      const int parent = kHumanoid[c].parent;
      skeleton.names.emplace_back(kHumanoid[c].name);
      skeleton.parents.push_back(parent);
      const Vec3 offset =
          parent < 0 ? world * body::Offset(c) : Vec3(rest[parent].conjugate() * body::Offset(c));
      skeleton.offsets.push_back(left_handed ? Mirrored(offset) : offset);
    }
  }

  // A canonical pose as this rig sends it.
  RigPose Pose(const body::Pose& pose) const {
    body::WorldPose at;
    body::ForwardKinematics(pose, at);
    RigPose out(skeleton);
    for (int c = 0; c < kJointCount; ++c) {
      const int parent = kHumanoid[c].parent;
      const Quat here = world * at.rotations[c] * rest[c];
      Quat local = here;
      if (parent >= 0) local = (world * at.rotations[parent] * rest[parent]).conjugate() * here;
      out.rotations[c] = left_handed ? Mirrored(local) : local;
    }
    const Vec3 hips = world * pose.hips_position_m;
    out.translations[0] = left_handed ? Mirrored(hips) : hips;
    return out;
  }
};

body::Pose Standing(StandingPose pose) {
  body::Pose standing;
  if (pose == StandingPose::kN) {
    const auto turn = [](float angle) { return Quat(Eigen::AngleAxisf(angle, Vec3::UnitZ())); };
    standing.rotations[body::kLeftUpperArm] = turn(-1.5707963F);
    standing.rotations[body::kRightUpperArm] = turn(1.5707963F);
  }
  return standing;
}

// Binds random poses and compares the local rotations and the hips' height.
void ExpectTheSame(const Unknown& rig, const Calibrated& calibrated, Random& random) {
  auto binding = Binding::Make(calibrated.spec);
  ASSERT_TRUE(binding.ok()) << binding.status().message();
  for (int i = 0; i < 20; ++i) {
    const body::Pose wanted = random.AnyPose();
    body::Pose got;
    RigPose sent = rig.Pose(wanted);
    if (calibrated.mirrored) Mirror(sent);
    binding.value().Bind(sent, got);
    for (int c = 0; c < kJointCount; ++c) {
      EXPECT_LT(kDegrees * Angle_rad(wanted.rotations[c], got.rotations[c]), 2.0F)
          << kHumanoid[c].name;
    }
    EXPECT_LT((wanted.hips_position_m - got.hips_position_m).norm(), 0.005F);
    RigPose back(rig.skeleton);
    binding.value().Unbind(got, sent, back);
    for (int c = 0; c < kJointCount; ++c) {
      EXPECT_LT(kDegrees * Angle_rad(back.rotations[c], sent.rotations[c]), 0.1F) << c;
    }
    EXPECT_LT((back.translations[0] - sent.translations[0]).norm(), 1e-4F);
  }
}

TEST(CalibrationTest, NamesTheJointThatStandsWrongAndTheLargestAngle) {
  Random random(1);
  const Unknown rig(random, Quat::Identity(), false);
  body::Pose raised = Standing(StandingPose::kT);
  raised.rotations[body::kRightLowerArm] = Quat(Eigen::AngleAxisf(0.8F, Vec3::UnitY()));
  const auto wrong = Calibrate(rig.skeleton, rig.Pose(raised), StandingPose::kT);
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.status().message().find("rightLowerArm stands 46 degrees off a T-pose"),
            std::string::npos)
      << wrong.status().message();
  const auto other =
      Calibrate(rig.skeleton, rig.Pose(Standing(StandingPose::kN)), StandingPose::kT);
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.status().message().find("90 degrees off a T-pose"), std::string::npos);
}

TEST(CalibrationTest, RefusesASkeletonWhoseJointsItCannotName) {
  Random random(1);
  Unknown rig(random, Quat::Identity(), false);
  LoseLeftLeg(rig.skeleton);
  const auto result =
      Calibrate(rig.skeleton, rig.Pose(Standing(StandingPose::kT)), StandingPose::kT);
  ASSERT_FALSE(result.ok());
  EXPECT_NE(result.status().message().find("leftLowerLeg"), std::string::npos);
}

TEST(CalibrationTest, RefusesAPerformerWhoIsNowhere) {
  Random random(1);
  Unknown rig(random, Quat::Identity(), false);
  for (Vec3& offset : rig.skeleton.offsets) offset.setZero();
  RigPose pose(rig.skeleton);
  EXPECT_FALSE(Calibrate(rig.skeleton, pose, StandingPose::kT).ok());
}

TEST(CalibrationTest, ARigOfAnyAxesAnyRestAndEitherHandMatchesAfterOneTOrNPose) {
  Random random(7);
  const Quat z_up = body::ShortestTurn(Vec3::UnitY(), Vec3::UnitZ());
  for (const StandingPose pose : {StandingPose::kT, StandingPose::kN}) {
    for (const bool left_handed : {false, true}) {
      for (const Quat& axes : {Quat::Identity(), z_up, Quat(Eigen::AngleAxisf(0.6F, Vec3::UnitY())),
                               Quat(z_up * Eigen::AngleAxisf(2.5F, Vec3::UnitY()))}) {
        const Unknown rig(random, axes, left_handed);
        EXPECT_FALSE(BindDialect(rig.skeleton).ok()) << "nobody could know this rig's rest";
        const auto calibrated = Calibrate(rig.skeleton, rig.Pose(Standing(pose)), pose);
        ASSERT_TRUE(calibrated.ok()) << calibrated.status().message();
        EXPECT_EQ(calibrated.value().mirrored, left_handed);
        ExpectTheSame(rig, calibrated.value(), random);
      }
    }
  }
}

TEST(CalibrationTest, AStanceAFewDegreesOffIsTakenAndTold) {
  Random random(3);
  const Unknown rig(random, Quat::Identity(), false);
  body::Pose sloppy = Standing(StandingPose::kT);
  sloppy.rotations[body::kLeftUpperArm] = Quat(Eigen::AngleAxisf(-0.2F, Vec3::UnitZ()));
  const auto calibrated = Calibrate(rig.skeleton, rig.Pose(sloppy), StandingPose::kT);
  ASSERT_TRUE(calibrated.ok()) << calibrated.status().message();
  EXPECT_NE(calibrated.value().bones.front().joint.find("left"), std::string::npos);
  EXPECT_NEAR(calibrated.value().bones.front().degrees, 11.5F, 0.5F);
}

}  // namespace
}  // namespace styled::rig
