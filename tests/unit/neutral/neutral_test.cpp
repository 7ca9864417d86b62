#include "model/neutral/neutral.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "model/body/heading.h"
#include "model/neutral/tuning.h"
#include "model/synthetic/performer.h"
#include "tests/unit/body/random_pose.h"

namespace styled::neutral {
namespace {

using body::kJointCount;
using body::Pose;
using body::Quat;

constexpr float kDegree = 0.017453293F;

std::vector<Pose> Perform(const std::string& script, double seconds, double rate_hz = 120) {
  synthetic::Performer performer({.seed = 1, .script = synthetic::ParseScript(script).value()});
  std::vector<Pose> poses;
  for (int i = 0; i < static_cast<int>(seconds * rate_hz); ++i) {
    performer.Pose(i / rate_hz, poses.emplace_back());
  }
  return poses;
}

// The mean rotations of the synthetic performer in one motion, by a sum of quaternions.
Carriage MeanOf(const std::string& script) {
  Carriage mean;
  std::array<Eigen::Vector4f, kJointCount> sums;
  sums.fill(Eigen::Vector4f::Zero());
  for (const Pose& pose : Perform(script, 20)) {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      Quat q = pose.rotations[j];
      if (j == body::kHips) q = body::Yaw(-body::Heading_rad(world)) * q;
      sums[j] += q.coeffs().dot(sums[j]) < 0 ? -q.coeffs() : q.coeffs();
    }
  }
  for (std::size_t j = 0; j < kJointCount; ++j) mean.rotations[j] = Quat(sums[j]).normalized();
  return mean;
}

// The reference is the synthetic performer; strangers hold each joint in another way.
class NeutralTest : public testing::Test {
 protected:
  NeutralTest() {
    reference_.walking = MeanOf("walk:60");
    reference_.standing = MeanOf("stand:60");
    reference_.running = MeanOf("run:60");
    body::Random random(5);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      stranger_.rotations[j] = random.Turn(15 * kDegree);
    }
    stranger_.rotations[body::kHips] = Quat(Eigen::AngleAxisf(10 * kDegree, body::Vec3::UnitX()));
  }
  // The same motion, held as the stranger does: what a neutral has to take out again.
  Pose AsStranger(const Pose& pose) const {
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    const Quat heading = body::Yaw(body::Heading_rad(world));
    Pose held = pose;
    for (std::size_t j = 1; j < kJointCount; ++j) {
      held.rotations[j] = stranger_.rotations[j].conjugate() * pose.rotations[j];
    }
    held.rotations[body::kHips] = heading * stranger_.rotations[body::kHips].conjugate() *
                                  heading.conjugate() * pose.rotations[body::kHips];
    return held;
  }
  void Follow(const std::vector<Pose>& poses, double rate_hz = 120, bool learns = true) {
    for (const Pose& pose : poses) {
      neutral_.Follow(pose, static_cast<float>(1 / rate_hz), learns, reference_);
    }
  }
  std::vector<Pose> Strangers(const std::string& script, double seconds, double rate_hz = 120) {
    auto poses = Perform(script, seconds, rate_hz);
    for (Pose& pose : poses) pose = AsStranger(pose);
    return poses;
  }
  // By how much the turns in effect differ from `expected`, rms of joints, degrees.
  double Apart_deg(const Carriage& expected) const {
    double sum = 0;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const double angle = body::Angle_rad(neutral_.turns().rotations[j], expected.rotations[j]);
      sum += angle * angle;
    }
    return std::sqrt(sum / static_cast<double>(kJointCount)) / static_cast<double>(kDegree);
  }

  Reference reference_;
  Carriage stranger_;
  Neutral neutral_;
};

TEST_F(NeutralTest, TheReferencesOwnNeutralIsNearlyZero) {
  Follow(Perform("walk:60", 20));
  EXPECT_LT(Apart_deg(Carriage()), 1.5);
}

TEST_F(NeutralTest, AWalkingStrangersNeutralIsKnownWithinThreeSeconds) {
  const double before = Apart_deg(stranger_);
  Follow(Strangers("walk:60", 3));
  EXPECT_LT(Apart_deg(stranger_), 0.3 * before);
  Follow(Strangers("walk:60", 20));
  EXPECT_LT(Apart_deg(stranger_), 0.15 * before);
  EXPECT_GT(neutral_.learned(), 0.95F);
}

TEST_F(NeutralTest, ARunningStrangersNeutralIsKnownToo) {
  const double before = Apart_deg(stranger_);
  Follow(Strangers("run:60", 20));
  EXPECT_LT(Apart_deg(stranger_), 0.3 * before);
}

TEST_F(NeutralTest, ThePoseThatTheNetworkSeesIsTheReferences) {
  Follow(Strangers("walk:60", 30));
  double worst_rad = 0;
  for (const Pose& pose : Perform("walk:60", 2)) {
    const Pose held = AsStranger(pose);
    neutral_.Follow(held, 1.0F / 120, true, reference_);
    Pose seen;
    neutral_.RemoveCarriage(held, seen);
    EXPECT_EQ(seen.hips_position_m, held.hips_position_m);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      worst_rad = std::max(worst_rad, body::Angle_rad(seen.rotations[j], pose.rotations[j]));
    }
  }
  EXPECT_LT(worst_rad, 4 * kDegree);
}

TEST_F(NeutralTest, OfAMirroredPerformerItIsTheMirrorImage) {
  Follow(Strangers("walk:60", 5));
  const Pose pose = AsStranger(Perform("walk:60", 1).back());
  Pose expected, mirrored, got;
  neutral_.Follow(pose, 0, false, reference_);
  neutral_.RemoveCarriage(pose, expected);
  body::Mirror(expected, expected);
  body::Mirror(pose, mirrored);
  const Neutral unaware = neutral_;
  neutral_.Mirror();
  neutral_.Follow(mirrored, 0, false, reference_);
  neutral_.RemoveCarriage(mirrored, got);
  double unaware_rad = 0;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    EXPECT_LT(body::Angle_rad(got.rotations[j], expected.rotations[j]), 1e-4) << j;
    unaware_rad = std::max(
        unaware_rad, body::Angle_rad(unaware.turns().rotations[j], neutral_.turns().rotations[j]));
  }
  EXPECT_GT(unaware_rad, 5 * kDegree) << "the stranger is not symmetric";
  EXPECT_EQ(neutral_.body_s(), unaware.body_s());
}

// The known neutral of a mirrored performer, kept as that of the performer themselves, and known
// again to either. The reference is symmetric, as those of weights are.
TEST_F(NeutralTest, WhatIsKnownIsMirroredLikeThePerformer) {
  for (Carriage* const usual : {&reference_.walking, &reference_.standing, &reference_.running}) {
    const gait::Rotations other = gait::Mirrored(usual->rotations);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      usual->rotations[j] = usual->rotations[j].slerp(0.5F, other[j]).normalized();
    }
  }
  Follow(Strangers("walk:60", 5));
  const Known known = neutral_.Tell(reference_);
  EXPECT_TRUE(Mirrored(Mirrored(known)) == known);
  neutral_.Mirror();
  Neutral other;
  other.Know(Mirrored(known), reference_);
  EXPECT_EQ(other.body_s(), neutral_.body_s());
  const Known told = neutral_.Tell(reference_);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    EXPECT_LT(body::Angle_rad(other.Tell(reference_).own.rotations[j], told.own.rotations[j]), 1e-3)
        << j;
  }
}

TEST_F(NeutralTest, IsTheSameWhereverOneWalks) {
  const auto poses = Strangers("walk:60", 5);
  Follow(poses);
  const Carriage here = neutral_.turns();
  neutral_ = Neutral();
  for (const Pose& pose : poses) {
    neutral_.Follow(body::Moved(pose, 2, {7, 0, -3}), 1.0F / 120, true, reference_);
  }
  EXPECT_LT(Apart_deg(here), 0.05);
}

TEST_F(NeutralTest, TheSignOfAQuaternionMeansNothing) {
  auto poses = Strangers("walk:60", 5);
  Follow(poses);
  const Carriage here = neutral_.turns();
  neutral_ = Neutral();
  for (std::size_t i = 0; i < poses.size(); i += 2) {
    for (Quat& q : poses[i].rotations) q.coeffs() = -q.coeffs();
  }
  Follow(poses);
  EXPECT_LT(Apart_deg(here), 0.05);
}

TEST_F(NeutralTest, DoesNotDependOnTheRateOfFrames) {
  Follow(Strangers("walk:60", 5, 240), 240);
  const Carriage fast = neutral_.turns();
  neutral_ = Neutral();
  Follow(Strangers("walk:60", 5, 60), 60);
  EXPECT_LT(Apart_deg(fast), 1);
}

TEST_F(NeutralTest, AStandingStrangersNeutralIsKnownToo) {
  const double before = Apart_deg(stranger_);
  Follow(Strangers("stand:60", 20));
  EXPECT_LT(Apart_deg(stranger_), 0.3 * before);
  EXPECT_GT(neutral_.arms_s(), 5);
}

// A performer on guard, or with crossed arms.
TEST_F(NeutralTest, NothingIsLearnedOfWhoStandsWithBentElbows) {
  auto poses = Strangers("stand:60", 20);
  for (Pose& pose : poses) {
    for (const int elbow : {body::kLeftLowerArm, body::kRightLowerArm}) {
      const float side = elbow == body::kLeftLowerArm ? -1.0F : 1.0F;
      pose.rotations[static_cast<std::size_t>(elbow)] =
          Quat(Eigen::AngleAxisf(side * 2.0F, body::Vec3::UnitY()));
    }
  }
  Follow(poses);
  EXPECT_LT(neutral_.body_s(), 0.1F);
}

TEST_F(NeutralTest, NothingIsLearnedOfAWideStance) {
  auto poses = Strangers("stand:60", 20);
  for (Pose& pose : poses) {
    for (const int leg : {body::kLeftUpperLeg, body::kRightUpperLeg}) {
      const float side = leg == body::kLeftUpperLeg ? 1.0F : -1.0F;
      body::Quat& rotation = pose.rotations[static_cast<std::size_t>(leg)];
      rotation = Quat(Eigen::AngleAxisf(side * 0.35F, body::Vec3::UnitZ())) * rotation;
    }
  }
  Follow(poses);
  EXPECT_LT(neutral_.body_s(), 0.1F);
}

// Each beside the walk that it must leave as it is.
class NotOrdinary : public NeutralTest {
 protected:
  NotOrdinary() {
    Follow(Strangers("walk:60", 30));
    known_ = neutral_.turns();
  }
  void ExpectNothingLearned(const std::vector<Pose>& poses) {
    Follow(poses);
    EXPECT_LT(Apart_deg(known_), 0.5);
  }
  Carriage known_;
};

// A run leans and bends the arms: that is a run, and no other carriage.
TEST_F(NotOrdinary, ARunChangesLittle) {
  Follow(Strangers("run:120", 60));
  EXPECT_LT(Apart_deg(known_), 2);
}

TEST_F(NotOrdinary, ABowHeldForAMinuteIsNotEaten) {
  Pose pose = AsStranger(Perform("stand:5", 1).back());
  pose.rotations[body::kHips] =
      pose.rotations[body::kHips] * Quat(Eigen::AngleAxisf(1.0F, body::Vec3::UnitX()));
  ExpectNothingLearned(std::vector<Pose>(60 * 120, pose));
}

TEST_F(NotOrdinary, ACrouchHeldForAMinuteIsNotEaten) {
  Pose pose = AsStranger(Perform("stand:5", 1).back());
  for (const int leg : {body::kLeftUpperLeg, body::kRightUpperLeg}) {
    const auto thigh = static_cast<std::size_t>(leg);
    pose.rotations[thigh] = Quat(Eigen::AngleAxisf(-1.2F, body::Vec3::UnitX()));
    pose.rotations[thigh + 1] = Quat(Eigen::AngleAxisf(2.0F, body::Vec3::UnitX()));
  }
  ExpectNothingLearned(std::vector<Pose>(60 * 120, pose));
}

TEST_F(NotOrdinary, ArmsHeldUpForAMinuteOfWalkingAreNotEaten) {
  auto poses = Strangers("walk:120", 60);
  for (Pose& pose : poses) {
    pose.rotations[body::kLeftUpperArm] = Quat::Identity();  // a T-pose
    pose.rotations[body::kRightUpperArm] = Quat::Identity();
  }
  Follow(poses);
  for (const int joint : {body::kLeftUpperArm, body::kRightUpperArm}) {
    const auto j = static_cast<std::size_t>(joint);
    EXPECT_LT(body::Angle_rad(neutral_.turns().rotations[j], known_.rotations[j]), 0.5 * kDegree);
  }
}

TEST_F(NotOrdinary, MotionInAnotherStyleIsNotRemoved) {
  Follow(Perform("walk:120", 60), 120, /*learns=*/false);
  EXPECT_LT(Apart_deg(known_), 0.05);
}

TEST_F(NeutralTest, NoTurnIsBeyondItsBound) {
  for (Quat& turn : stranger_.rotations) turn = Quat(Eigen::AngleAxisf(1.4F, body::Vec3::UnitY()));
  stranger_.rotations[body::kHips] = Quat::Identity();
  Follow(Strangers("walk:60", 20));
  for (std::size_t j = 0; j < kJointCount; ++j) {
    EXPECT_LT(body::Angle_rad(neutral_.turns().rotations[j], Quat::Identity()),
              tuning::kMostCollar_rad + 1e-3F);
  }
}

TEST_F(NeutralTest, ACalibrationHoldsWhatItWasShown) {
  Follow(Perform("walk:60", 20));
  neutral_.Calibrate(5);
  Follow(Strangers("stand:2,walk:60", 5.1));
  EXPECT_TRUE(neutral_.calibrated());
  Follow(Strangers("stand:1", 1));
  const Carriage shown = neutral_.turns();
  EXPECT_LT(Apart_deg(stranger_), 4);
  Follow(Perform("walk:120", 60));
  EXPECT_LT(Apart_deg(shown), 0.05) << "nothing more is learned";
}

TEST_F(NeutralTest, ACalibrationThatShowsNeitherStandingNorWalkingIsNone) {
  neutral_.Calibrate(3);
  Pose lying;
  lying.rotations[body::kHips] = Quat(Eigen::AngleAxisf(-1.5F, body::Vec3::UnitX()));
  Follow(std::vector<Pose>(5 * 120, lying));
  EXPECT_FALSE(neutral_.calibrated());
  EXPECT_EQ(neutral_.calibrates_s(), 0);
  Follow(Strangers("walk:60", 5));
  EXPECT_GT(neutral_.learned(), 0.8F) << "it goes on as without";
}

TEST_F(NeutralTest, ALearnedNeutralIsKeptForAnotherNetwork) {
  Follow(Strangers("walk:60", 20));
  const Known known = neutral_.Tell(reference_);
  Neutral same;
  same.Know(known, reference_);
  EXPECT_LT(Apart_deg(same.turns()), 0.5) << "at once";
  EXPECT_EQ(same.learned(), neutral_.learned());
  // A network whose performers are the stranger finds nothing to take out.
  Reference theirs = reference_;
  theirs.walking = known.own;
  neutral_.Know(known, theirs);
  EXPECT_LT(Apart_deg(Carriage()), 0.1);
}

TEST_F(NeutralTest, AJumpOfTheOriginIsNoRun) {
  auto poses = Strangers("walk:60", 6);
  for (std::size_t i = poses.size() / 2; i < poses.size(); ++i) {
    poses[i] = body::Moved(poses[i], 0, {500, 0, 0});
  }
  Follow(poses);
  EXPECT_GT(neutral_.body_s(), 5);
}

TEST_F(NeutralTest, ForgettingFadesOut) {
  Follow(Strangers("walk:60", 20));
  neutral_.Forget();
  EXPECT_EQ(neutral_.learned(), 0);
  const auto crouch = Pose();  // a T-pose: nothing is learned of its arms
  neutral_.Follow(crouch, 1.0F / 120, false, reference_);
  EXPECT_GT(Apart_deg(Carriage()), 5) << "not at once";
  for (int i = 0; i < 240; ++i) neutral_.Follow(crouch, 1.0F / 120, false, reference_);
  EXPECT_LT(Apart_deg(Carriage()), 0.05);
}

std::vector<std::byte> Written(Neutral& neutral) {
  Checkpoint count;
  neutral.Carry(count);
  std::vector<std::byte> bytes(count.size());
  auto into = Checkpoint::Into(bytes);
  neutral.Carry(into);
  return bytes;
}

TEST_F(NeutralTest, ACheckpointGoesOnBitForBit) {
  Follow(Strangers("walk:60", 5));
  const auto bytes = Written(neutral_);
  Neutral other;
  auto from = Checkpoint::From(bytes);
  other.Carry(from);
  ASSERT_TRUE(from.complete());
  for (const Pose& pose : Strangers("walk:60", 2)) {
    neutral_.Follow(pose, 1.0F / 120, true, reference_);
    other.Follow(pose, 1.0F / 120, true, reference_);
  }
  EXPECT_EQ(Written(other), Written(neutral_));
}

// A turn that is not a rotation would make every later frame unsound.
TEST_F(NeutralTest, ACheckpointWithoutSenseIsRefused) {
  const auto bytes = Written(neutral_);
  // Two carriages, three times and the heading; the other parts' own tests damage the rest.
  constexpr std::size_t kNumbers = 2 * 4 * std::size_t{kJointCount} + 4;
  for (std::size_t at = 0; at < 4 * kNumbers; at += 4) {
    auto damaged = bytes;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(&damaged[at], &nan, 4);
    Neutral other;
    auto from = Checkpoint::From(damaged);
    other.Carry(from);
    EXPECT_FALSE(from.ok()) << "number " << at / 4;
  }
}

}  // namespace
}  // namespace styled::neutral
