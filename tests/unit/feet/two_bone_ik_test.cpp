#include "model/feet/two_bone_ik.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/body/random_pose.h"

namespace styled::feet {
namespace {

using body::Random;

// A leg at any place, its knee bent by `bend_rad` about its hinge.
TwoBones Leg(Random& random, float bend_rad) {
  TwoBones limb;
  const Quat turn = random.Turn(3.1F);
  const float thigh = random.Between(0.2F, 0.6F);
  const float shank = thigh * random.Between(0.7F, 1.3F);
  limb.hip = random.Vector(3);
  limb.hinge = turn * Vec3::UnitX();
  limb.knee = limb.hip + turn * Vec3(0, -thigh, 0);
  limb.ankle =
      limb.knee + turn * (Quat(Eigen::AngleAxisf(bend_rad, Vec3::UnitX())) * Vec3(0, -shank, 0));
  return limb;
}

struct Solved {
  Vec3 knee, ankle;
};
Solved Apply(const TwoBones& limb, const TwoBoneTurns& turns) {
  const Vec3 thigh = limb.knee - limb.hip;
  const Vec3 knee = limb.hip + turns.upper * thigh;
  return {knee, knee + turns.upper * (turns.lower * (limb.ankle - limb.knee))};
}
float Length(const TwoBones& limb) {
  return (limb.knee - limb.hip).norm() + (limb.ankle - limb.knee).norm();
}
// The knee's bend about the hinge that the thigh carries: positive is forwards.
float Bend(const TwoBones& limb, const TwoBoneTurns& turns) {
  const Solved s = Apply(limb, turns);
  const Vec3 thigh = (s.knee - limb.hip).normalized();
  const Vec3 shank = (s.ankle - s.knee).normalized();
  const Vec3 hinge = turns.upper * limb.hinge;
  return std::atan2(thigh.cross(shank).dot(hinge), thigh.dot(shank));
}

TEST(TwoBoneIkTest, ReachesEveryTargetWithinReachAndKeepsLengthsAndTheKneesSide) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const TwoBones limb = Leg(random, random.Between(0.02F, 2.3F));
    const float length = Length(limb);
    const Vec3 direction = (random.Vector(1) + Vec3(1e-3F, 0, 0)).normalized();
    const Vec3 target = limb.hip + random.Between(0.35F, 0.995F) * length * direction;
    const TwoBoneTurns turns = ReachFor(limb, target);
    const Solved s = Apply(limb, turns);
    ASSERT_LT((s.ankle - target).norm(), 5e-4F * length) << i;
    ASSERT_NEAR((s.knee - limb.hip).norm(), (limb.knee - limb.hip).norm(), 1e-5F);
    ASSERT_NEAR((s.ankle - s.knee).norm(), (limb.ankle - limb.knee).norm(), 1e-5F);
    ASSERT_GT(Bend(limb, turns), 0) << i;
  }
}

// A style bends the knee from its natural side to far backwards while the foot is held: the knee
// follows without snapping through, if necessary at the expense of the foot's place.
TEST(TwoBoneIkTest, AKneeThatAStyleBendsBackwardsNeverSnaps) {
  for (const float share : {0.97F, 0.9F, 0.8F}) {
    float before = 0;
    for (int step = 0; step <= 2000; ++step) {
      Random random(2);  // the same leg
      const TwoBones limb = Leg(random, 0.5F - 0.001F * static_cast<float>(step));
      const TwoBoneTurns turns = ReachFor(limb, limb.hip + share * (limb.ankle - limb.hip));
      const float bent = Bend(limb, turns);
      if (step > 0) ASSERT_NEAR(bent, before, 0.02F) << share << " " << step;
      const Vec3 target = limb.hip + share * (limb.ankle - limb.hip);
      ASSERT_NEAR(turns.missed, (Apply(limb, turns).ankle - target).norm(), 1e-3F) << step;
      before = bent;
    }
    EXPECT_LT(before, 0) << "in the end it bends as the style has it";
  }
}

TEST(TwoBoneIkTest, AStraightOrSlightlyOverstretchedKneeBendsForwardsWithoutAJump) {
  Random random(3);
  for (const float bend : {-0.1F, -0.02F, 0.0F, 0.02F}) {
    const TwoBones limb = Leg(random, bend);
    const float now = (limb.ankle - limb.hip).norm();
    const Vec3 direction = (limb.ankle - limb.hip) / now;
    float before = bend;
    for (int step = 0; step <= 20000; ++step) {
      const float share = 1 - 0.3F * std::pow(static_cast<float>(step) / 20000.0F, 2);
      const TwoBoneTurns turns = ReachFor(limb, limb.hip + share * now * direction);
      const float bent = Bend(limb, turns);
      // The law of cosines itself behaves like the root of the distance; a flip would be 2 * bend.
      ASSERT_NEAR(bent, before, step == 0 ? 1e-3F : 0.02F) << bend << " " << step;
      before = bent;
    }
    EXPECT_GT(before, 0.5F);
  }
}

TEST(TwoBoneIkTest, OutOfReachItEndsOnTheLineAndSaysByHowMuch) {
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const TwoBones limb = Leg(random, random.Between(0.02F, 2.3F));
    const float length = Length(limb);
    const Vec3 direction = (random.Vector(1) + Vec3(1e-3F, 0, 0)).normalized();
    const Vec3 target = limb.hip + 1.3F * length * direction;
    const TwoBoneTurns turns = ReachFor(limb, target);
    const Vec3 reached = Apply(limb, turns).ankle - limb.hip;
    ASSERT_NEAR(reached.norm(), length, 2e-3F * length);
    ASSERT_GT(reached.normalized().dot(direction), 1 - 1e-5F);
    ASSERT_NEAR(turns.missed, 0.3F * length, 2e-3F * length);
  }
}

TEST(TwoBoneIkTest, ATargetAtTheAnkleTurnsNothing) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const TwoBones limb = Leg(random, random.Between(-0.2F, 2.3F));
    const TwoBoneTurns turns = ReachFor(limb, limb.ankle);
    ASSERT_LT(body::Angle_rad(turns.lower, Quat::Identity()), 2e-3);
    ASSERT_LT(body::Angle_rad(turns.upper, Quat::Identity()), 2e-3);
  }
}

TEST(TwoBoneIkTest, NoLimbIsTooShortToBeAsked) {
  TwoBones limb;
  limb.hip = limb.knee = limb.ankle = Vec3(1, 2, 3);
  limb.hinge = Vec3::UnitX();
  const TwoBoneTurns turns = ReachFor(limb, Vec3(1, 2, 4));
  EXPECT_TRUE(turns.upper.isApprox(Quat::Identity()));
  EXPECT_FLOAT_EQ(turns.missed, 1);
}

TEST(TwoBoneIkTest, TheSoftReachNeverStretchesTheLimb) {
  float before = 0;
  for (float wanted = 0.1F; wanted < 2; wanted += 1e-3F) {
    const float reach = SoftReach(wanted, 0.84F, 0.01F);
    EXPECT_LT(reach, 0.84F);
    EXPECT_GE(reach, before);
    if (wanted < 0.7F) {
      EXPECT_NEAR(reach, wanted, 2e-4F);
    }
    before = reach;
  }
}

}  // namespace
}  // namespace styled::feet
