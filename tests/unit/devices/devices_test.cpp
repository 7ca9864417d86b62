#include "model/devices/devices.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/devices/limb.h"
#include "tests/support/units.h"
#include "tests/unit/devices/mounted.h"

namespace styled::devices {
namespace {

using testing::kMs;
using testing::Worn;

using support::kDegrees;
const std::vector<int> kSix{body::kHead, body::kLeftHand, body::kRightHand,
                            body::kHips, body::kLeftFoot, body::kRightFoot};

Quat About(const Vec3& axis, float angle) { return Quat(Eigen::AngleAxisf(angle, axis)); }

// A pose that six devices can tell: arms and legs bend about their hinges.
body::Pose Pose() {
  body::Pose pose;
  pose.hips_position_m = {0.3F, 0.85F, 0.5F};
  pose.rotations[body::kHips] = About(Vec3::UnitY(), 0.4F);
  pose.rotations[body::kLeftUpperLeg] = About(Vec3::UnitX(), -0.7F);
  pose.rotations[body::kLeftLowerLeg] = About(Vec3::UnitX(), 0.9F);
  pose.rotations[body::kRightUpperLeg] = About(Vec3::UnitX(), 0.1F);
  pose.rotations[body::kRightLowerLeg] = About(Vec3::UnitX(), 0.3F);
  pose.rotations[body::kLeftUpperArm] = About(Vec3::UnitZ(), -1.1F);
  pose.rotations[body::kLeftLowerArm] = About(Vec3::UnitY(), -0.8F);
  pose.rotations[body::kRightUpperArm] = About(Vec3::UnitZ(), 0.9F);
  return pose;
}

struct Stage {
  explicit Stage(std::vector<int> parts, std::uint64_t seed = 5, float heading = 0, float scale = 1)
      : worn(std::move(parts), seed, heading, scale) {}
  void Calibrate() {
    worn.Measure(body::Pose(), now_ns, devices);
    outcome = devices.Reset(now_ns, worn.TrueStance());
  }
  // The resulting pose, in the performer's own space.
  body::Pose Solve(const body::Pose& pose) {
    for (int i = 0; i < 2; ++i) worn.Measure(pose, now_ns += 20 * kMs, devices);
    body::Pose found;
    EXPECT_TRUE(devices.Solve(now_ns, found));
    return worn.Back(found);
  }
  Worn worn;
  Devices devices{Devices::Options{}};
  rig::Trackers::Outcome outcome;
  std::int64_t now_ns = 0;
};

body::WorldPose World(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return world;
}

TEST(Devices, StandInTheRestPoseUntilTheyAreCalibrated) {
  Stage stage(kSix);
  const body::Pose found = stage.Solve(Pose());
  EXPECT_EQ(found.rotations[body::kLeftLowerArm].w(), 1);
}

TEST(Devices, GiveTheTPoseOfACalibrationBackHoweverTheyAreMounted) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    Stage stage(kSix, seed, 0.3F * static_cast<float>(seed), 0.8F);
    stage.Calibrate();
    const body::WorldPose found = World(stage.Solve({})), expected = World({});
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      EXPECT_LT((found.positions_m[j] - expected.positions_m[j]).norm(), 0.005F)
          << body::kHumanoid[j].name;
      EXPECT_LT(kDegrees * found.rotations[j].angularDistance(expected.rotations[j]), 1.5F)
          << body::kHumanoid[j].name;
    }
  }
}

TEST(Devices, AreFollowedInPlaceAndRotationWhereTheyAreWorn) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Stage stage(kSix, seed, 0.3F * static_cast<float>(seed), 1.2F);
    stage.Calibrate();
    const body::WorldPose found = World(stage.Solve(Pose())), expected = World(Pose());
    for (const int part : kSix) {
      const auto j = static_cast<std::size_t>(part);
      EXPECT_LT((found.positions_m[j] - expected.positions_m[j]).norm(), 0.01F)
          << body::kHumanoid[j].name;
      EXPECT_LT(kDegrees * found.rotations[j].angularDistance(expected.rotations[j]), 0.5F)
          << body::kHumanoid[j].name;
    }
  }
}

TEST(Devices, BendKneesForwards) {
  Stage stage(kSix);
  stage.Calibrate();
  const body::Pose found = stage.Solve(Pose());
  const auto& knee = found.rotations[body::kLeftLowerLeg];
  EXPECT_NEAR(kDegrees * knee.angularDistance(Quat::Identity()), kDegrees * 0.9F, 2);
  EXPECT_GT(knee.x(), 0);
  const auto knee_at = World(found).positions_m[body::kLeftLowerLeg];
  EXPECT_LT((knee_at - World(Pose()).positions_m[body::kLeftLowerLeg]).norm(), 0.03F);
}

TEST(Devices, ThatAreGoneAreNotTrackedAndTakeWhatFollowsFromThemAlong) {
  Stage stage(kSix);
  stage.Calibrate();
  (void)stage.Solve(Pose());
  // The left foot falls silent for 0.6 s; the others go on.
  const Worn others({body::kHead, body::kLeftHand, body::kRightHand, body::kHips, body::kRightFoot},
                    0);
  body::Pose found;
  for (int i = 0; i < 30; ++i) others.Measure(Pose(), stage.now_ns += 20 * kMs, stage.devices);
  ASSERT_TRUE(stage.devices.Solve(stage.now_ns, found));
  for (const int part : {body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot}) {
    EXPECT_FALSE(found.rotations[static_cast<std::size_t>(part)].coeffs().allFinite()) << part;
  }
  for (const int part : {body::kHips, body::kHead, body::kRightFoot, body::kRightUpperLeg}) {
    EXPECT_TRUE(found.rotations[static_cast<std::size_t>(part)].coeffs().allFinite()) << part;
  }
  EXPECT_FALSE(stage.devices.Solve(stage.now_ns + 600 * kMs, found)) << "all are silent";
}

TEST(Devices, OfHeadAndHandsStandOnTheFloorAndCrouchWithTheHead) {
  Stage stage({body::kHead, body::kLeftHand, body::kRightHand}, 0);
  stage.Calibrate();
  body::Pose low;
  low.hips_position_m.y() -= 0.3F;
  const body::WorldPose found = World(stage.Solve(low));
  EXPECT_NEAR(found.positions_m[body::kHips].y(), 0.68F, 0.01F);
  for (const int foot : {body::kLeftFoot, body::kRightFoot}) {
    EXPECT_NEAR(found.positions_m[static_cast<std::size_t>(foot)].y(), 0.09F, 0.01F);
  }
}

TEST(Devices, ThatTellOnlyAPlaceMoveWhatTheyAreOn) {
  Stage stage({body::kHips, body::kLeftFoot, body::kRightFoot}, 0);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Quat none(kNan, kNan, kNan, kNan);
  const Vec3 at(0.4F, 1.49F, -1.29F);
  stage.devices.Add(body::kHead, 0, at, none);
  stage.Calibrate();
  body::Pose found;
  const Worn& worn = stage.worn;
  for (int i = 0; i < 2; ++i) {
    stage.devices.Add(body::kHead, stage.now_ns += 20 * kMs, at + Vec3(0, -0.08F, 0.25F), none);
    worn.Measure({}, stage.now_ns, stage.devices);
  }
  ASSERT_TRUE(stage.devices.Solve(stage.now_ns, found));
  const body::WorldPose world = World(worn.Back(found));
  EXPECT_NEAR(world.positions_m[body::kHead].z(), 0.25F, 0.03F) << "the spine leans";
}

TEST(Devices, AreNotDisturbedByWhatIsOutOfReachOrInOnePlace) {
  Stage stage(kSix);
  stage.Calibrate();
  for (const float far : {0.0F, 50.0F}) {
    body::Pose found;
    for (int i = 0; i < 2; ++i) {
      stage.now_ns += 20 * kMs;
      for (const int part : kSix) {
        stage.devices.Add(body::Joint(part), stage.now_ns,
                          Vec3(far * static_cast<float>(part), 0, 0), Quat::Identity());
      }
    }
    ASSERT_TRUE(stage.devices.Solve(stage.now_ns, found));
    EXPECT_TRUE(found.hips_position_m.allFinite());
    for (const Quat& q : found.rotations) EXPECT_NEAR(q.norm(), 1, 1e-3F);
  }
}

TEST(Limb, ReachesWithItsJointTowardsThePole) {
  for (int index = 0; index < kLimbs; ++index) {
    const Limb& limb = LimbOf(index);
    const Vec3 target = 0.4F * limb.along + Vec3(0.02F, 0.03F, 0.1F);
    const Vec3 pole(0.1F, -0.5F, 1);
    const LimbTurns turns = Bend(limb, Vec3::Zero(), target, pole);
    const Vec3 middle = turns.upper * body::Offset(limb.lower);
    const Vec3 end = middle + turns.lower * body::Offset(limb.end);
    EXPECT_NEAR((end - target).norm(), 0, 1e-3F) << index;
    const Vec3 across = middle - middle.dot(target) / target.squaredNorm() * target;
    EXPECT_GT(across.normalized().dot(
                  (pole - pole.dot(target) / target.squaredNorm() * target).normalized()),
              0.99F)
        << index;
    const Quat bend = turns.upper.conjugate() * turns.lower;
    EXPECT_GT(bend.vec().dot(limb.hinge) * bend.w(), 0) << "flexed, not overstretched";
  }
}

}  // namespace
}  // namespace styled::devices
