#include "model/rig/trackers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <random>
#include <vector>

#include "model/synthetic/motion_tables.h"
#include "model/synthetic/performer.h"

namespace styled::rig {
namespace {

using body::Joint;
using body::kJointCount;
using Stance = Trackers::Stance;

constexpr float kPi = 3.14159265F;
constexpr std::int64_t kPeriod_ns = 10'000'000;
constexpr std::int64_t kStart_ns = 5'000'000'000;

const std::vector<Joint> kAllWorn{body::kHips,          body::kChest,         body::kHead,
                                  body::kLeftUpperArm,  body::kLeftLowerArm,  body::kLeftHand,
                                  body::kRightUpperArm, body::kRightLowerArm, body::kRightHand,
                                  body::kLeftUpperLeg,  body::kLeftLowerLeg,  body::kLeftFoot,
                                  body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot};

Quat About(const Vec3& axis, float angle) { return Quat(Eigen::AngleAxisf(angle, axis)); }
Quat X(float angle) { return About(Vec3::UnitX(), angle); }
Quat Y(float angle) { return About(Vec3::UnitY(), angle); }
Quat Z(float angle) { return About(Vec3::UnitZ(), angle); }
float Degrees(const Quat& a, const Quat& b) { return a.angularDistance(b) * 180 / kPi; }

bool IsOfArm(int j) { return j >= body::kLeftShoulder && j <= body::kRightHand; }

body::WorldPose World(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return world;
}

body::Pose NPose() {
  body::Pose pose;
  pose.rotations[body::kLeftUpperArm] = Z(-kPi / 2);
  pose.rotations[body::kRightUpperArm] = Z(kPi / 2);
  return pose;
}

// The second pose of a mounting reset.
body::Pose Skier(Stance stance) {
  body::WorldPose world;
  world.rotations.fill(Quat::Identity());
  for (const int j : {body::kHips, body::kSpine, body::kChest, body::kNeck, body::kHead}) {
    world.rotations[j] = X(0.6F);
  }
  for (const int side : {0, 4}) {
    world.rotations[body::kLeftUpperLeg + side] = X(-0.9F);
    world.rotations[body::kLeftLowerLeg + side] = X(0.5F);
    world.rotations[body::kLeftFoot + side] = world.rotations[body::kLeftToes + side] = X(0.4F);
    const Quat hanging = Z(side == 0 ? -kPi / 2 : kPi / 2);
    const Quat arm = stance == Stance::kTPose ? hanging : X(-kPi / 2) * hanging;
    for (int k = 0; k < 4; ++k) world.rotations[body::kLeftShoulder + side + k] = arm;
  }
  body::Pose pose;
  for (int j = 0; j < kJointCount; ++j) {
    const int parent = body::kHumanoid[j].parent;
    pose.rotations[j] =
        parent < 0 ? world.rotations[j] : world.rotations[parent].conjugate() * world.rotations[j];
  }
  return pose;
}

// A performer's trackers with arbitrary mountings and start headings, and their measurements of a
// pose.
class Worn {
 public:
  Worn(std::vector<Joint> parts, std::uint64_t seed) : parts_(std::move(parts)), random_(seed) {
    for (const Joint j : parts_) {
      heading_[j] = Between(-kPi, kPi);
      part_from_sensor_[j].setIdentity();
    }
  }

  // Mounts the sensors as usual, with every tilt and rotation that keeps their heading.
  Worn& AsUsual(Stance stance) {
    for (const Joint j : parts_) {
      const Quat towards = Y(Trackers::Facing(j, stance));
      const float lift = Between(-1.0F, 1.0F), turn = Between(-kPi, kPi);
      if (stance == Stance::kTPose && IsOfArm(j)) {
        // The sensor's +Y, raised by the angle, has that heading; the rotation about it is
        // arbitrary.
        part_from_sensor_[j] = towards * X(kPi / 2 - lift) * Y(turn);
      } else {
        const Quat rest = World(NPose()).rotations[j];
        part_from_sensor_[j] = rest.conjugate() * towards * X(-lift) * Z(turn);
      }
    }
    return *this;
  }
  Worn& Anyhow() {
    for (const Joint j : parts_) {
      part_from_sensor_[j] =
          Quat(Between(-1, 1), Between(-1, 1), Between(-1, 1), Between(-1, 1)).normalized();
    }
    return *this;
  }
  // Lets the headings drift apart.
  Worn& Drift() {
    for (const Joint j : parts_) heading_[j] += Between(-0.5F, 0.5F);
    return *this;
  }

  Quat Says(Joint j, const body::Pose& pose) const {
    return Y(heading_[j]) * World(pose).rotations[j] * part_from_sensor_[j];
  }
  void Tell(Trackers& trackers, std::int64_t time_ns, const body::Pose& pose) const {
    for (const Joint j : parts_) trackers.Add(j, time_ns, Says(j, pose));
  }
  const std::vector<Joint>& parts() const { return parts_; }

 private:
  float Between(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }
  std::vector<Joint> parts_;
  std::mt19937_64 random_;
  std::array<float, kJointCount> heading_{};
  std::array<Quat, kJointCount> part_from_sensor_;
};

Trackers::Options AtOnce(Stance stance = Stance::kTPose) {
  Trackers::Options options;
  options.stance = stance;
  options.delay_ns = 0;
  return options;
}

std::uint32_t Bits(const std::vector<Joint>& parts) {
  std::uint32_t bits = 0;
  for (const Joint j : parts) bits |= 1U << static_cast<unsigned>(j);
  return bits;
}

// Follows the performer for `seconds`; returns the largest angle error of any tracked part.
float WorstDegrees(Trackers& trackers, const Worn& worn, std::int64_t start_ns,
                   std::uint64_t seed = 3, double seconds = 20) {
  synthetic::Options options;
  options.seed = seed;
  synthetic::Performer performer(options);
  float worst = 0;
  body::Pose truth, pose;
  for (int i = 1; i < seconds * 100; ++i) {
    performer.Pose(i * 0.01, truth);
    const std::int64_t now_ns = start_ns + i * kPeriod_ns;
    worn.Tell(trackers, now_ns, truth);
    EXPECT_TRUE(trackers.Solve(now_ns, pose));
    const auto expected = World(truth).rotations, found = World(pose).rotations;
    for (const Joint j : worn.parts()) worst = std::max(worst, Degrees(expected[j], found[j]));
  }
  return worst;
}

TEST(Trackers, GiveTheRestPoseBeforeTheFirstReset) {
  Trackers trackers(AtOnce());
  body::Pose pose;
  EXPECT_FALSE(trackers.Solve(kStart_ns, pose)) << "nobody is there";
  body::Pose truth;
  truth.rotations[body::kLeftUpperLeg] = X(-1);
  Worn(kAllWorn, 1).Tell(trackers, kStart_ns, truth);
  pose.rotations[body::kHips] = X(1);
  ASSERT_TRUE(trackers.Solve(kStart_ns, pose));
  for (const Quat& q : pose.rotations) EXPECT_EQ(q.coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(pose.hips_position_m.y(), body::kHumanoid[body::kHips].y_m);
  EXPECT_FALSE(trackers.Solve(kStart_ns + 400'000'000, pose));
}

TEST(Trackers, ThatAreSilentAreNotReset) {
  Trackers trackers(AtOnce());
  Worn(kAllWorn, 1).Tell(trackers, kStart_ns, {});
  EXPECT_EQ(trackers.ResetFull(kStart_ns + 400'000'000).done, 0U);
  EXPECT_EQ(trackers.ResetFull(kStart_ns + 200'000'000).done, Bits(kAllWorn));
}

TEST(Trackers, AreRecoveredAfterAFullResetInATPose) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Trackers trackers(AtOnce());
    const Worn worn = Worn(kAllWorn, seed).AsUsual(Stance::kTPose);
    worn.Tell(trackers, kStart_ns, {});
    const auto outcome = trackers.ResetFull(kStart_ns);
    EXPECT_EQ(outcome.done, Bits(kAllWorn));
    EXPECT_EQ(outcome.left, 0U);
    EXPECT_LT(WorstDegrees(trackers, worn, kStart_ns, seed), 0.2F) << seed;
  }
}

TEST(Trackers, AreRecoveredAfterAFullResetInAnNPose) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Trackers trackers(AtOnce(Stance::kNPose));
    const Worn worn = Worn(kAllWorn, seed).AsUsual(Stance::kNPose);
    worn.Tell(trackers, kStart_ns, NPose());
    trackers.ResetFull(kStart_ns);
    EXPECT_LT(WorstDegrees(trackers, worn, kStart_ns, seed), 0.2F) << seed;
  }
}

// The negative control: if a sensor does not point as assumed, one pose does not determine it.
TEST(Trackers, WornAnyhowAreNotRecoveredByAFullResetAlone) {
  Trackers trackers(AtOnce());
  const Worn worn = Worn(kAllWorn, 1).Anyhow();
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  EXPECT_GT(WorstDegrees(trackers, worn, kStart_ns), 20);
}

TEST(Trackers, WornAnyhowAreRecoveredWithAMountingReset) {
  for (const Stance stance : {Stance::kTPose, Stance::kNPose}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Trackers trackers(AtOnce(stance));
      const Worn worn = Worn(kAllWorn, seed).Anyhow();
      worn.Tell(trackers, kStart_ns, stance == Stance::kTPose ? body::Pose() : NPose());
      trackers.ResetFull(kStart_ns);
      worn.Tell(trackers, kStart_ns + kPeriod_ns, Skier(stance));
      const auto outcome = trackers.ResetMounting(kStart_ns + kPeriod_ns);
      EXPECT_EQ(outcome.done, Bits(kAllWorn));
      EXPECT_EQ(outcome.left, 0U);
      EXPECT_LT(WorstDegrees(trackers, worn, kStart_ns + kPeriod_ns, seed), 0.3F) << seed;
    }
  }
}

// A mounting reset measures how the tracker is mounted, which stays valid when headings drift.
TEST(Trackers, NeedNoSecondMountingReset) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Trackers trackers(AtOnce());
    Worn worn = Worn(kAllWorn, seed).Anyhow();
    worn.Tell(trackers, kStart_ns, {});
    trackers.ResetFull(kStart_ns);
    worn.Tell(trackers, kStart_ns + 1, Skier(Stance::kTPose));
    trackers.ResetMounting(kStart_ns + 1);
    worn.Drift().Drift().Tell(trackers, kStart_ns + 2, {});
    trackers.ResetFull(kStart_ns + 2);
    EXPECT_LT(WorstDegrees(trackers, worn, kStart_ns + 2, seed), 0.3F) << seed;
  }
}

TEST(Trackers, ThatDriftedAreRecoveredByAYawReset) {
  Trackers trackers(AtOnce());
  Worn worn = Worn(kAllWorn, 5).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  worn.Drift();
  EXPECT_GT(WorstDegrees(trackers, worn, kStart_ns), 10);
  const std::int64_t later_ns = kStart_ns + 30'000'000'000;
  worn.Tell(trackers, later_ns, NPose());  // standing at ease, looking ahead
  const auto outcome = trackers.ResetYaw(later_ns);
  EXPECT_EQ(outcome.done, Bits(kAllWorn));
  EXPECT_LT(WorstDegrees(trackers, worn, later_ns), 0.2F);
}

TEST(Trackers, AreRecoveredByAMountingResetThatFollowsAYawReset) {
  Trackers trackers(AtOnce());
  Worn worn = Worn({body::kHips, body::kChest, body::kLeftUpperLeg}, 6).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  worn.Drift().Tell(trackers, kStart_ns + 1, {});
  trackers.ResetYaw(kStart_ns + 1);
  worn.Tell(trackers, kStart_ns + 2, Skier(Stance::kTPose));
  trackers.ResetMounting(kStart_ns + 2);
  EXPECT_LT(WorstDegrees(trackers, worn, kStart_ns + 2), 0.3F);
}

TEST(Trackers, ThatDidNotTurnAreLeftByAMountingReset) {
  Trackers trackers(AtOnce());
  const Worn worn = Worn({body::kHips, body::kLeftFoot, body::kHead}, 7).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  body::Pose flat = Skier(Stance::kTPose);
  const auto world = World(flat).rotations;
  flat.rotations[body::kLeftFoot] = world[body::kLeftLowerLeg].conjugate();
  flat.rotations[body::kHead] = world[body::kNeck].conjugate() * Y(0.8F);  // looks aside
  worn.Tell(trackers, kStart_ns + 1, flat);
  const auto outcome = trackers.ResetMounting(kStart_ns + 1);
  EXPECT_EQ(outcome.done, Bits({body::kHips}));
  EXPECT_EQ(outcome.left, Bits({body::kLeftFoot, body::kHead}));
  EXPECT_LT(WorstDegrees(trackers, worn, kStart_ns + 1), 0.2F);
}

TEST(Trackers, ThatCameAfterTheFullResetAreNamedByTheOthers) {
  Trackers trackers(AtOnce());
  const Worn worn = Worn({body::kHips}, 8).AsUsual(Stance::kTPose);
  const Worn late = Worn({body::kChest}, 8).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  late.Tell(trackers, kStart_ns, {});
  EXPECT_EQ(trackers.ResetYaw(kStart_ns).left, Bits({body::kChest}));
  EXPECT_EQ(trackers.ResetMounting(kStart_ns).left, Bits({body::kHips, body::kChest}));
}

body::Pose SolveOne(const std::vector<Joint>& parts, const body::Pose& truth) {
  Trackers trackers(AtOnce());
  const Worn worn = Worn(parts, 9).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  worn.Tell(trackers, kStart_ns + 1, truth);
  body::Pose pose;
  EXPECT_TRUE(trackers.Solve(kStart_ns + 1, pose));
  return pose;
}

TEST(Trackers, SplitTheSpineBetweenHipsAndChest) {
  body::Pose truth;
  truth.rotations[body::kHips] = Y(0.5F);
  truth.rotations[body::kSpine] = X(0.8F);
  const auto pose = SolveOne({body::kHips, body::kChest}, truth);
  EXPECT_LT(Degrees(pose.rotations[body::kSpine], X(0.4F)), 0.1F);
  EXPECT_LT(Degrees(pose.rotations[body::kChest], X(0.4F)), 0.1F);
  EXPECT_LT(Degrees(pose.rotations[body::kNeck], Quat::Identity()), 0.1F);
}

TEST(Trackers, SplitTheNeckBetweenChestAndHead) {
  body::Pose truth;
  truth.rotations[body::kHead] = Y(1.0F);
  const auto pose = SolveOne({body::kHips, body::kHead}, truth);
  EXPECT_LT(Degrees(pose.rotations[body::kNeck], Y(0.5F)), 0.1F);
  EXPECT_LT(Degrees(pose.rotations[body::kHead], Y(0.5F)), 0.1F);
  EXPECT_LT(Degrees(pose.rotations[body::kChest], Quat::Identity()), 0.1F);
}

TEST(Trackers, LetPartsWithoutOneFollowTheirParents) {
  body::Pose truth;
  truth.rotations[body::kLeftUpperArm] = Z(-1.0F);
  truth.rotations[body::kLeftUpperLeg] = X(-0.7F);
  truth.rotations[body::kLeftLowerLeg] = X(0.9F);
  const auto pose = SolveOne({body::kHips, body::kLeftUpperArm, body::kLeftUpperLeg}, truth);
  for (const int j : {body::kLeftLowerArm, body::kLeftHand, body::kLeftLowerLeg, body::kLeftFoot,
                      body::kLeftToes, body::kRightUpperLeg, body::kChest}) {
    EXPECT_LT(Degrees(pose.rotations[j], Quat::Identity()), 0.1F) << j;
  }
  EXPECT_LT(Degrees(pose.rotations[body::kLeftUpperLeg], X(-0.7F)), 0.1F);
}

TEST(Trackers, WithoutOneAtTheHipsTakeTheirHeadingFromAbove) {
  body::Pose truth;
  truth.rotations[body::kHips] = Y(1.2F);
  truth.rotations[body::kChest] = X(0.5F);
  auto pose = SolveOne({body::kChest, body::kHead}, truth);
  EXPECT_LT(Degrees(pose.rotations[body::kHips], Y(1.2F)), 0.1F);
  EXPECT_LT(Degrees(World(pose).rotations[body::kChest], Y(1.2F) * X(0.5F)), 0.1F);
  truth.rotations[body::kSpine] = X(0.3F);
  pose = SolveOne({body::kSpine}, truth);
  EXPECT_LT(Degrees(pose.rotations[body::kHips], Y(1.2F) * X(0.3F)), 0.1F);
  pose = SolveOne({body::kLeftFoot}, truth);
  EXPECT_LT(Degrees(pose.rotations[body::kHips], Quat::Identity()), 0.1F);
}

bool IsNan(const Quat& q) { return q.coeffs().array().isNaN().all(); }

TEST(Trackers, ThatFallSilentAreHeldAndToldAsNan) {
  Trackers trackers(AtOnce());
  const Worn arm = Worn({body::kLeftUpperArm}, 1).AsUsual(Stance::kTPose);
  const Worn rest =
      Worn({body::kHips, body::kChest, body::kLeftLowerArm}, 2).AsUsual(Stance::kTPose);
  arm.Tell(trackers, kStart_ns, {});
  rest.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  body::Pose truth, pose;
  truth.rotations[body::kLeftUpperArm] = Z(-0.5F);
  arm.Tell(trackers, kStart_ns + 1, truth);
  rest.Tell(trackers, kStart_ns + 1, truth);
  ASSERT_TRUE(trackers.Solve(kStart_ns + 1, pose));
  // The body turns; the upper arm sends nothing more.
  truth.rotations[body::kHips] = Y(0.7F);
  const std::int64_t soon_ns = kStart_ns + 290'000'000, later_ns = kStart_ns + 310'000'000;
  rest.Tell(trackers, soon_ns, truth);
  ASSERT_TRUE(trackers.Solve(soon_ns, pose));
  EXPECT_FALSE(IsNan(pose.rotations[body::kLeftUpperArm]));
  rest.Tell(trackers, later_ns - 1, truth);
  ASSERT_TRUE(trackers.Solve(later_ns, pose));
  EXPECT_TRUE(IsNan(pose.rotations[body::kLeftUpperArm]));
  for (int j = 0; j < kJointCount; ++j) {
    EXPECT_EQ(IsNan(pose.rotations[j]), j == body::kLeftUpperArm) << j;
  }
  EXPECT_TRUE(pose.hips_position_m.allFinite());
  // The upper arm sends again.
  arm.Tell(trackers, later_ns + 1, truth);
  rest.Tell(trackers, later_ns + 1, truth);
  ASSERT_TRUE(trackers.Solve(later_ns + 1, pose));
  EXPECT_LT(Degrees(pose.rotations[body::kLeftUpperArm], Z(-0.5F)), 0.1F);
}

// The stylist holds the joint's rotation relative to its parent, so the joints below it must be
// computed with the held rotation.
TEST(Trackers, TellWhatIsBelowASilentOneWithRegardToWhatIsHeld) {
  Trackers trackers(AtOnce());
  const Worn arm = Worn({body::kLeftUpperArm}, 1).AsUsual(Stance::kTPose);
  const Worn rest = Worn({body::kHips, body::kLeftLowerArm}, 2).AsUsual(Stance::kTPose);
  body::Pose truth, pose;
  arm.Tell(trackers, kStart_ns, truth);
  rest.Tell(trackers, kStart_ns, truth);
  trackers.ResetFull(kStart_ns);
  truth.rotations[body::kLeftUpperArm] = Z(-0.5F);
  arm.Tell(trackers, kStart_ns + 1, truth);
  rest.Tell(trackers, kStart_ns + 1, truth);
  ASSERT_TRUE(trackers.Solve(kStart_ns + 1, pose));
  truth.rotations[body::kHips] = Y(0.7F);
  truth.rotations[body::kLeftLowerArm] = Y(-0.4F);
  const std::int64_t later_ns = kStart_ns + 400'000'000;
  rest.Tell(trackers, later_ns, truth);
  ASSERT_TRUE(trackers.Solve(later_ns, pose));
  pose.rotations[body::kLeftUpperArm] = Z(-0.5F);  // held
  EXPECT_LT(Degrees(World(pose).rotations[body::kLeftLowerArm],
                    World(truth).rotations[body::kLeftLowerArm]),
            0.1F);
}

TEST(Trackers, ThatAreAllSilentGiveNoPose) {
  Trackers trackers(AtOnce());
  const Worn worn = Worn(kAllWorn, 1).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  body::Pose pose;
  EXPECT_TRUE(trackers.Solve(kStart_ns + 300'000'000, pose));
  EXPECT_FALSE(trackers.Solve(kStart_ns + 300'000'001, pose));
}

TEST(Trackers, AreTakenAtTheTimeOfThePoseBetweenTheirSamples) {
  Trackers::Options options;
  options.delay_ns = kPeriod_ns;
  Trackers trackers(options);
  trackers.Add(body::kHips, 0, Quat::Identity());
  trackers.ResetFull(0);
  for (int i = 1; i <= 20; ++i) trackers.Add(body::kHips, i * kPeriod_ns, Y(0.1F * i));
  body::Pose pose;
  const auto heading_at = [&](std::int64_t now_ns) {
    EXPECT_TRUE(trackers.Solve(now_ns, pose));
    return Degrees(pose.rotations[body::kHips], Quat::Identity()) * kPi / 180;
  };
  EXPECT_NEAR(heading_at(20 * kPeriod_ns), 1.9F, 1e-3F);
  EXPECT_NEAR(heading_at(20 * kPeriod_ns + kPeriod_ns / 4), 1.925F, 1e-3F);
  // the next sample is late
  EXPECT_NEAR(heading_at(21 * kPeriod_ns + kPeriod_ns / 4), 2.025F, 1e-3F);
  EXPECT_NEAR(heading_at(22 * kPeriod_ns), 2.05F, 1e-3F);  // very late: no further extrapolation
  EXPECT_NEAR(heading_at(30 * kPeriod_ns), 2.05F, 1e-3F);
  EXPECT_NEAR(heading_at(10 * kPeriod_ns), 1.3F, 1e-3F);  // the oldest sample that is kept
  trackers.Add(body::kHips, 19 * kPeriod_ns, Y(3));       // older than the last: dropped
  EXPECT_NEAR(heading_at(22 * kPeriod_ns), 2.05F, 1e-3F);
  trackers.Add(body::kHips, 20 * kPeriod_ns, Y(2.1F));  // replaces the last
  EXPECT_NEAR(heading_at(21 * kPeriod_ns), 2.1F, 1e-3F);
  EXPECT_NEAR(heading_at(20 * kPeriod_ns), 1.9F, 1e-3F);
}

TEST(Trackers, ThatJumpAreNotThrownFurther) {
  Trackers::Options options;
  options.delay_ns = kPeriod_ns;
  Trackers trackers(options);
  trackers.Add(body::kHips, 0, Quat::Identity());
  trackers.ResetFull(0);
  trackers.Add(body::kHips, kPeriod_ns, Y(1.5F));
  body::Pose pose;
  EXPECT_TRUE(trackers.Solve(2 * kPeriod_ns + kPeriod_ns / 2, pose));
  EXPECT_NEAR(Degrees(pose.rotations[body::kHips], Y(1.5F)), 0.05F * 180 / kPi, 0.01F);
}

TEST(Trackers, WhoseSamplesComeInBurstsAreNotThrownAhead) {
  Trackers::Options options;
  options.delay_ns = kPeriod_ns;
  Trackers trackers(options);
  trackers.Add(body::kHips, 0, Quat::Identity());
  trackers.ResetFull(0);
  // Two samples, 10 ms apart, arrive within 0.1 ms, every 20 ms.
  for (int i = 1; i <= 20; ++i) {
    trackers.Add(body::kHips, (i + i % 2) * kPeriod_ns - i % 2 * 100'000, Y(0.1F * i));
  }
  body::Pose pose;
  EXPECT_TRUE(trackers.Solve(21 * kPeriod_ns + kPeriod_ns / 2, pose));
  EXPECT_NEAR(Degrees(pose.rotations[body::kHips], Quat::Identity()) * kPi / 180, 2.05F, 0.01F);
}

// Sensors of 100 Hz each, out of step, are resampled: the rest of the error is the motion within
// less than a period.
TEST(Trackers, OutOfStepGiveThePoseOfOneTime) {
  Trackers::Options options;
  options.delay_ns = 12'000'000;
  Trackers trackers(options);
  const Worn worn = Worn(kAllWorn, 4).AsUsual(Stance::kTPose);
  worn.Tell(trackers, 0, {});
  trackers.ResetFull(0);
  synthetic::Options script;
  script.script = synthetic::ParseScript("walk:20").value();
  synthetic::Performer performer(script), truth_performer(script);
  body::Pose truth, said, pose;
  float worst = 0;
  for (std::int64_t ms = 1; ms < 10'000; ++ms) {
    performer.Pose(static_cast<double>(ms) * 1e-3, said);
    for (std::size_t k = 0; k < kAllWorn.size(); ++k) {
      if (ms % 10 != static_cast<std::int64_t>(k * 7 % 10)) continue;
      trackers.Add(kAllWorn[k], ms * 1'000'000, worn.Says(kAllWorn[k], said));
    }
    if (ms % 10 != 3 || ms < 100) continue;
    ASSERT_TRUE(trackers.Solve(ms * 1'000'000, pose));
    truth_performer.Pose(static_cast<double>(ms - 12) * 1e-3, truth);
    const auto expected = World(truth).rotations, found = World(pose).rotations;
    for (const Joint j : kAllWorn) worst = std::max(worst, Degrees(expected[j], found[j]));
  }
  EXPECT_LT(worst, 0.5F);
}

const std::vector<Joint> kLegsWorn{body::kHips,          body::kChest,         body::kLeftUpperLeg,
                                   body::kLeftLowerLeg,  body::kLeftFoot,      body::kLeftToes,
                                   body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot,
                                   body::kRightToes};

struct Track {
  std::vector<body::Pose> truth, found;
};

Track Follow(const std::string& script, int frames, const std::vector<Joint>& parts) {
  Trackers trackers(AtOnce());
  const Worn worn = Worn(parts, 2).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  synthetic::Options options;
  options.script = synthetic::ParseScript(script).value();
  synthetic::Performer performer(options);
  Track track;
  for (int i = 1; i <= frames; ++i) {
    body::Pose truth, pose;
    performer.Pose(i * 0.01, truth);
    worn.Tell(trackers, kStart_ns + i * kPeriod_ns, truth);
    EXPECT_TRUE(trackers.Solve(kStart_ns + i * kPeriod_ns, pose));
    track.truth.push_back(truth);
    track.found.push_back(pose);
  }
  return track;
}

TEST(TrackersPlace, OfTheRestPoseIsThatOfTheHumanoid) {
  const auto pose = SolveOne({body::kHips}, {});
  EXPECT_NEAR(pose.hips_position_m.x(), 0, 1e-5F);
  EXPECT_NEAR(pose.hips_position_m.y(), body::kHumanoid[body::kHips].y_m, 1e-4F);
  EXPECT_NEAR(pose.hips_position_m.z(), 0, 1e-5F);
}

// The synthetic performer's soles are thicker than the humanoid's at rest: the only difference.
TEST(TrackersPlace, HasTheHeightOfThePerformersHips) {
  const float soles = static_cast<float>(synthetic::kToeHeight_m) - 0.02F;
  for (const std::string script : {"stand:60", "walk:60", "wave-both:60"}) {
    const Track track = Follow(script, 1000, kLegsWorn);
    for (std::size_t i = 100; i < track.truth.size(); ++i) {
      ASSERT_NEAR(track.found[i].hips_position_m.y() + soles, track.truth[i].hips_position_m.y(),
                  0.005F)
          << script << " " << i;
    }
  }
}

// Heel and ball of both feet, at the sole.
std::array<Vec3, 4> Soles(const body::Pose& pose) {
  const auto world = World(pose);
  std::array<Vec3, 4> soles;
  for (int side = 0; side < 2; ++side) {
    const int foot = side == 0 ? body::kLeftFoot : body::kRightFoot;
    soles[2 * side] = world.positions_m[foot] + world.rotations[foot] * Vec3(0, -0.09F, -0.03F);
    soles[2 * side + 1] =
        world.positions_m[foot + 1] + world.rotations[foot + 1] * Vec3(0, -0.02F, 0);
  }
  return soles;
}

// When the weight passes to another sole, the old one may have risen by this much since the last
// frame.
TEST(TrackersPlace, LetsAFootOnTheFloorNotSlide) {
  constexpr float kNearFloor_m = 0.02F;
  const Track track = Follow("walk:20,turn-left:10,stand:5", 3500, kLegsWorn);
  for (std::size_t i = 1; i < track.found.size(); ++i) {
    const auto before = Soles(track.found[i - 1]), now = Soles(track.found[i]);
    float least_m = 1, lowest_m = 1;
    for (std::size_t k = 0; k < now.size(); ++k) {
      lowest_m = std::min(lowest_m, now[k].y());
      const Vec3 moved = now[k] - before[k];
      if (now[k].y() < kNearFloor_m) least_m = std::min(least_m, std::hypot(moved.x(), moved.z()));
    }
    ASSERT_LT(least_m, 5e-5F) << i;
    ASSERT_NEAR(lowest_m, 0, 5e-5F) << i;
  }
}

TEST(TrackersPlace, DoesNotJumpFromFootToFoot) {
  const Track track = Follow("walk:20,turn-right:10,stand:5", 3500, kLegsWorn);
  float fastest_m = 0, performer_m = 0;
  for (std::size_t i = 1; i < track.found.size(); ++i) {
    const auto step = [i](const std::vector<body::Pose>& poses) {
      return (poses[i].hips_position_m - poses[i - 1].hips_position_m).norm();
    };
    fastest_m = std::max(fastest_m, step(track.found));
    performer_m = std::max(performer_m, step(track.truth));
  }
  EXPECT_LT(fastest_m, 1.2F * performer_m);
}

TEST(TrackersPlace, GoesWhereTheWalkerGoes) {
  const Track track = Follow("walk:60", 2000, kLegsWorn);
  const auto way = [](const std::vector<body::Pose>& poses) {
    return (poses.back().hips_position_m - poses.front().hips_position_m).eval();
  };
  const Vec3 truth = way(track.truth), found = way(track.found);
  EXPECT_GT(truth.norm(), 10);
  EXPECT_LT((found - truth).norm(), 0.08F * truth.norm());
}

TEST(TrackersPlace, BeginsAtTheOriginWithEveryFullReset) {
  Trackers trackers(AtOnce());
  const Worn worn = Worn(kLegsWorn, 2).AsUsual(Stance::kTPose);
  worn.Tell(trackers, kStart_ns, {});
  trackers.ResetFull(kStart_ns);
  WorstDegrees(trackers, worn, kStart_ns, 3, 5);
  const std::int64_t later_ns = kStart_ns + 10'000'000'000;
  worn.Tell(trackers, later_ns, {});
  trackers.ResetFull(later_ns);
  body::Pose pose;
  ASSERT_TRUE(trackers.Solve(later_ns, pose));
  EXPECT_NEAR(pose.hips_position_m.x(), 0, 1e-4F);
  EXPECT_NEAR(pose.hips_position_m.z(), 0, 1e-4F);
}

}  // namespace
}  // namespace styled::rig
