#include "model/stylist/limb_gate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "model/net/gate_bounds.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

constexpr float kKnown_m = 0.04F, kUnknown_m = 0.4F;
constexpr net::GateBounds::Range kArms = net::GateBounds().arms;

PerLimb AllLimbs(float value) {
  PerLimb all;
  all.fill(value);
  return all;
}

PerLimb Only(Limb limb, float error_m) {
  PerLimb errors_m = AllLimbs(kKnown_m);
  errors_m[static_cast<std::size_t>(limb)] = error_m;
  return errors_m;
}

struct LimbGateTest : testing::Test {
  LimbGate gate;
  bool started = false;

  void Feed(const PerLimb& errors_m, float seconds, float rate_hz = 120) {
    for (int i = 0; i < static_cast<int>(seconds * rate_hz); ++i) {
      gate.Follow(errors_m, 1 / rate_hz, !started);
      started = true;
    }
  }
  float left_arm() const { return gate.weight(Limb::kLeftArm); }
};

TEST_F(LimbGateTest, KnownLimbsShowAllOfTheStyle) {
  Feed(AllLimbs(kKnown_m), 0.1F);
  EXPECT_EQ(gate.weights(), AllLimbs(1));
  EXPECT_FALSE(gate.reduces());
}

TEST_F(LimbGateTest, AnUnknownLimbKeepsItsOwnMotionAndReturnsSlowly) {
  Feed(AllLimbs(kKnown_m), 0.1F);
  Feed(AllLimbs(kUnknown_m), 4 * tuning::kGateClose_s);
  EXPECT_LT(left_arm(), 0.1F);
  EXPECT_TRUE(gate.reduces());
  Feed(AllLimbs(kUnknown_m), 2);
  EXPECT_NEAR(left_arm(), 0, 1e-4F);
  Feed(AllLimbs(kKnown_m), 4 * tuning::kGateClose_s);
  EXPECT_LT(left_arm(), 0.4F) << "it left faster";
  Feed(AllLimbs(kKnown_m), 12 * tuning::kGateOpen_s);
  EXPECT_NEAR(left_arm(), 1, 1e-3F);
}

TEST_F(LimbGateTest, TheFirstFrameIsJudgedAsItIs) {
  Feed(Only(Limb::kLeftArm, kUnknown_m), 0.01F);
  EXPECT_EQ(left_arm(), 0);
  EXPECT_EQ(gate.weight(Limb::kRightArm), 1);
}

TEST_F(LimbGateTest, ALargerErrorNeverShowsMore) {
  for (int limb = 0; limb < kLimbCount; ++limb) {
    float before = 1;
    for (float error_m = 0; error_m < 0.5F; error_m += 0.005F) {
      LimbGate fresh;
      fresh.Follow(Only(static_cast<Limb>(limb), error_m), 0, true);
      const float weight = fresh.weight(static_cast<Limb>(limb));
      EXPECT_LE(weight, before) << limb << " at " << error_m;
      before = weight;
    }
    EXPECT_EQ(before, 0) << limb;
  }
}

TEST_F(LimbGateTest, NoLimbCausesAnotherToFadeButArmsTheTrunk) {
  for (const Limb unknown :
       {Limb::kLeftArm, Limb::kRightArm, Limb::kTrunk, Limb::kLeftLeg, Limb::kRightLeg}) {
    LimbGate fresh;
    fresh.Follow(Only(unknown, kUnknown_m), 0, true);
    const bool arm = unknown == Limb::kLeftArm || unknown == Limb::kRightArm;
    for (int other = 0; other < kLimbCount; ++other) {
      const auto limb = static_cast<Limb>(other);
      const float share = limb == unknown               ? 0
                          : limb == Limb::kTrunk && arm ? 1 - tuning::kGateTrunkWithArms
                                                        : 1;
      EXPECT_FLOAT_EQ(fresh.weight(limb), share) << other;
    }
  }
}

TEST_F(LimbGateTest, AFlutteringErrorDoesNotMakeTheStyleFlutter) {
  const float middle_m = 0.5F * (kArms.begin_m + kArms.end_m);
  // Well within the band, because what is usual is learnt meanwhile.
  const float half_band_m = 0.2F * tuning::kGateBand_m;
  Feed(AllLimbs(middle_m + half_band_m), 3);
  LimbGate steady = gate;
  for (int i = 0; i < 240; ++i) {
    Feed(AllLimbs(middle_m + (i % 2 == 0 ? -half_band_m : half_band_m)), 1.01F / 120);
    steady.Follow(AllLimbs(middle_m + half_band_m), 1.0F / 120, false);
    ASSERT_NEAR(left_arm(), steady.weight(Limb::kLeftArm), 1e-4F) << i;
  }
}

TEST_F(LimbGateTest, ItsSpeedIsBoundedAtEveryRateAndTheSameAtAll) {
  // Two equal poles of time constant t move by at most 1 / (e t) of a step in a second.
  const float most_per_s = 1.05F / (std::exp(1.0F) * tuning::kGateClose_s);
  for (const float rate_hz : {24.0F, 30.0F, 60.0F, 120.0F, 240.0F}) {
    SCOPED_TRACE(rate_hz);
    gate.Reset();
    started = false;
    float before = 1;
    float fastest = 0;
    const auto step = [&](const PerLimb& errors_m) {
      gate.Follow(errors_m, 1 / rate_hz, !started);
      started = true;
      fastest = std::max(fastest, std::abs(left_arm() - before) * rate_hz);
      before = left_arm();
    };
    const auto frames = [&](float seconds) { return static_cast<int>(seconds * rate_hz); };
    for (int i = 0; i < frames(0.5F); ++i) step(AllLimbs(kKnown_m));
    for (int i = 0; i < frames(0.1F); ++i) step(AllLimbs(kUnknown_m));
    EXPECT_NEAR(before, 3 * std::exp(-2.0F), 0.35F) << "about two time constants later";
    for (int i = 0; i < frames(1); ++i) step(AllLimbs(kKnown_m));
    for (int i = 0; i < frames(1); ++i) step(AllLimbs(i % 3 == 0 ? kUnknown_m : kKnown_m));
    EXPECT_LE(fastest, most_per_s);
  }
}

TEST_F(LimbGateTest, AShortBurstDoesNotFallOnWhenItIsOver) {
  Feed(AllLimbs(kKnown_m), 0.1F);
  Feed(AllLimbs(kUnknown_m), tuning::kGateClose_s);
  const float at_the_end = left_arm();
  Feed(AllLimbs(kKnown_m), 3 * tuning::kGateClose_s);
  EXPECT_GT(left_arm(), 0.6F * at_the_end);
  const float least = left_arm();
  Feed(AllLimbs(kKnown_m), 0.1F);
  EXPECT_GT(left_arm(), least);
}

TEST_F(LimbGateTest, OnlyThePastCounts) {
  Feed(AllLimbs(kKnown_m), 0.5F);
  LimbGate other = gate;
  EXPECT_EQ(other.weights(), gate.weights());
  other.Follow(AllLimbs(kUnknown_m), 1.0F / 120, false);
  gate.Follow(AllLimbs(kKnown_m), 1.0F / 120, false);
  EXPECT_LT(other.weight(Limb::kLeftArm), gate.weight(Limb::kLeftArm))
      << "the frame at which it becomes unknown, not one later";
}

TEST_F(LimbGateTest, AnErrorThatIsNotANumberIsAnUnknownLimbAndIsForgotten) {
  Feed(AllLimbs(kKnown_m), 0.1F);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Feed(AllLimbs(bad), 1);
    EXPECT_NEAR(left_arm(), 0, 1e-3F);
    Feed(AllLimbs(kKnown_m), 12 * tuning::kGateOpen_s);
    EXPECT_NEAR(left_arm(), 1, 1e-3F);
  }
}

// Of another rig, whose errors never fall low.
TEST_F(LimbGateTest, APerformersUsualErrorsDoNotCountForLong) {
  const float usual_m = 0.5F * (kArms.begin_m + kArms.end_m);
  Feed(Only(Limb::kLeftArm, usual_m), 3);
  EXPECT_LT(left_arm(), 0.6F);
  Feed(Only(Limb::kLeftArm, usual_m), 60);
  EXPECT_GT(left_arm(), 0.95F);
  Feed(Only(Limb::kLeftArm, kUnknown_m), 1);
  EXPECT_LT(left_arm(), 0.05F) << "a punch still counts";
  started = false;
  Feed(Only(Limb::kLeftArm, usual_m), 1);
  EXPECT_GT(left_arm(), 0.95F) << "kept over a gap in the stream";
  gate.Reset();
  started = false;
  Feed(Only(Limb::kLeftArm, usual_m), 1);
  EXPECT_LT(left_arm(), 0.6F) << "forgotten";
}

// A second of punches, a second of guard, for two minutes.
TEST_F(LimbGateTest, PunchesDoNotBecomeUsual) {
  for (int i = 0; i < 60; ++i) {
    Feed(Only(Limb::kLeftArm, 0.5F * (kArms.end_m + kUnknown_m)), 1);
    EXPECT_LT(left_arm(), 0.05F) << i;
    Feed(Only(Limb::kLeftArm, kKnown_m), 1);
  }
}

TEST_F(LimbGateTest, ResetForgets) {
  Feed(AllLimbs(kUnknown_m), 1);
  gate.Reset();
  EXPECT_EQ(gate.weights(), AllLimbs(1));
}

TEST(LimbErrors, AreEachLimbsOwn) {
  const body::Pose input;
  EXPECT_EQ(LimbErrors_m(input.rotations, input.rotations), AllLimbs(0));

  body::Pose found = input;  // the left forearm straight up: the hand is 0.25 m away on two axes
  found.rotations[body::kLeftLowerArm] =
      body::Quat(Eigen::AngleAxisf(1.5707963F, body::Vec3::UnitZ()));
  PerLimb errors_m = LimbErrors_m(input.rotations, found.rotations);
  EXPECT_NEAR(errors_m[0], 0.25F * std::sqrt(2.0F) / 2, 1e-5F) << "mean of elbow and hand";
  for (int limb = 1; limb < kLimbCount; ++limb) {
    EXPECT_EQ(errors_m[static_cast<std::size_t>(limb)], 0) << limb;
  }

  found = input;  // a bow carries the arms and tells nothing of them; hips carry the legs
  found.rotations[body::kHips] = body::Quat(Eigen::AngleAxisf(0.5F, body::Vec3::UnitX()));
  errors_m = LimbErrors_m(input.rotations, found.rotations);
  EXPECT_GT(errors_m[static_cast<std::size_t>(Limb::kTrunk)], 0.1F);
  errors_m[static_cast<std::size_t>(Limb::kTrunk)] = 0;
  EXPECT_EQ(errors_m, AllLimbs(0));
}

TEST(LimbErrors, TheHeelOfAFootCountsButNotItsToes) {
  const body::Pose input;
  body::Pose found = input;
  found.rotations[body::kRightFoot] = body::Quat(Eigen::AngleAxisf(1, body::Vec3::UnitX()));
  EXPECT_EQ(LimbErrors_m(input.rotations, found.rotations), AllLimbs(0));
  found.rotations[body::kRightUpperLeg] = body::Quat(Eigen::AngleAxisf(1, body::Vec3::UnitX()));
  EXPECT_GT(LimbErrors_m(input.rotations, found.rotations)[4], 0.4F);
}

}  // namespace
}  // namespace styled::stylist
