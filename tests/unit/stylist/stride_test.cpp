#include "model/stylist/stride.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

using body::Vec3;

constexpr double kHole_s = 0.25;
constexpr float kSettle_s = 0.025F;

// Neutral, one that hurries, one that shuffles, one that was not measured.
const net::Styles kStyles{
    {.name = "neutral", .walk_mps = 1.2F, .run_mps = 3.1F, .walk_spm = 110, .run_spm = 155},
    {.name = "active", .walk_mps = 1.5F, .run_mps = 3.5F, .walk_spm = 132, .run_spm = 142},
    {.name = "old", .walk_mps = 0.8F, .run_mps = 1.5F, .walk_spm = 121, .run_spm = 159},
    {.name = "odd"}};
constexpr int kActive = 1, kOld = 2, kOdd = 3;

Mixer Mixed(std::initializer_list<net::StyleWeight> mix, Root root = Root::kStride,
            int input_style = 0) {
  Settings settings;
  std::copy(mix.begin(), mix.end(), settings.mix.begin());
  settings.root = root;
  settings.input_style = input_style;
  settings.transition_s = 0;
  Mixer mixer;
  mixer.Aim(settings);
  mixer.Advance(0);
  return mixer;
}

float Factor(const Mixer& mixer, float speed_mps) {
  return std::exp(LogStride(kStyles, mixer, speed_mps));
}

TEST(LogStrideTest, StandingIsNotScaledWalkAndRunByTheirOwnSpeeds) {
  const Mixer old = Mixed({{kOld, 1}});
  EXPECT_EQ(Factor(old, 0), 1);
  EXPECT_EQ(Factor(old, 0.1F), 1) << "a shift of weight";
  EXPECT_NEAR(Factor(old, 1.2F), 0.8F / 1.2F, 1e-4F);
  EXPECT_NEAR(Factor(old, 3.1F), 1.5F / 3.1F, 1e-4F);
  const Mixer active = Mixed({{kActive, 1}});
  EXPECT_NEAR(Factor(active, 1.2F), 1.25F, 1e-4F);
  EXPECT_NEAR(Factor(active, 3.1F), 3.5F / 3.1F, 1e-4F);
}

TEST(LogStrideTest, APerformerWhoGoesFasterIsNeverStyledSlower) {
  for (const int style : {kActive, kOld}) {
    const Mixer mixer = Mixed({{style, 1}});
    float before_mps = 0;
    for (float speed_mps = 0; speed_mps < 12; speed_mps += 0.01F) {
      const float styled_mps = speed_mps * Factor(mixer, speed_mps);
      EXPECT_GE(styled_mps, before_mps)
          << kStyles[static_cast<std::size_t>(style)].name << " at " << speed_mps << " m/s";
      before_mps = styled_mps;
    }
  }
}

TEST(LogStrideTest, AMixIsScaledByWeightAndAnInputStyleIsTakenOut) {
  EXPECT_NEAR(Factor(Mixed({{kOld, 0.5F}}), 1.2F), std::sqrt(0.8F / 1.2F), 1e-4F);
  EXPECT_NEAR(Factor(Mixed({{kOld, 0.5F}, {kActive, 0.5F}}), 1.2F), std::sqrt(0.8F * 1.5F) / 1.2F,
              1e-4F);
  EXPECT_NEAR(Factor(Mixed({{0, 1}}, Root::kStride, kOld), 0.8F), 1.2F / 0.8F, 1e-4F);
  EXPECT_NEAR(Factor(Mixed({{kActive, 1}}, Root::kStride, kOld), 0.8F), 1.5F / 0.8F, 1e-4F);
  Settings strong;
  strong.mix[0] = {kOld, 1};
  strong.strength = 0.5F;
  strong.root = Root::kStride;
  strong.transition_s = 0;
  Mixer mixer;
  mixer.Aim(strong);
  mixer.Advance(0);
  EXPECT_NEAR(Factor(mixer, 1.2F), std::sqrt(0.8F / 1.2F), 1e-4F) << "strength counts";
}

TEST(LogStrideTest, NothingIsScaledWithoutStrideStyleOrSpeeds) {
  for (const float speed_mps : {0.0F, 0.8F, 1.2F, 3.0F, 9.0F}) {
    EXPECT_EQ(Factor(Mixed({{kOld, 1}}, Root::kFollow), speed_mps), 1);
    EXPECT_EQ(Factor(Mixed({}), speed_mps), 1);
    EXPECT_EQ(Factor(Mixed({{kOdd, 1}}), speed_mps), 1);
    const net::Styles bare{{.name = "neutral"}, {.name = "active"}};
    EXPECT_EQ(LogStride(bare, Mixed({{kActive, 1}}), speed_mps), 0);
    EXPECT_EQ(LogStride({}, Mixed({{kActive, 1}}), speed_mps), 0);
  }
}

TEST(LogStrideTest, TheFactorIsBounded) {
  const net::Styles wild{{.name = "neutral", .walk_mps = 1.2F, .run_mps = 3.1F},
                         {.name = "fast", .walk_mps = 15, .run_mps = 15},
                         {.name = "slow", .walk_mps = 0.05F, .run_mps = 0.05F}};
  EXPECT_NEAR(std::exp(LogStride(wild, Mixed({{1, 1.5F}}), 1.2F)), tuning::kMostStride, 1e-4F);
  EXPECT_NEAR(std::exp(LogStride(wild, Mixed({{2, 1.5F}}), 1.2F)), tuning::kLeastStride, 1e-4F);
}

float Cadence(const Mixer& mixer, float speed_mps) {
  return std::exp(LogCadence(kStyles, mixer, speed_mps));
}

TEST(LogCadenceTest, StandingKeepsItsTimeWalksAndRunsHaveTheirOwnRatios) {
  const Mixer old = Mixed({{kOld, 1}});
  EXPECT_EQ(Cadence(old, 0), 1);
  EXPECT_EQ(Cadence(old, 0.1F), 1) << "a shift of weight";
  EXPECT_NEAR(Cadence(old, 1.2F), 121.0F / 110, 1e-4F);
  EXPECT_NEAR(Cadence(old, 3.1F), 159.0F / 155, 1e-4F);
  const Mixer active = Mixed({{kActive, 1}});
  EXPECT_NEAR(Cadence(active, 1.2F), 132.0F / 110, 1e-4F);
  EXPECT_NEAR(Cadence(active, 3.1F), 142.0F / 155, 1e-4F);
  EXPECT_EQ(Cadence(active, 0.9F), Cadence(active, 1.5F)) << "the performer's own pace is kept";
}

TEST(LogCadenceTest, IsOfTheMixWhateverTheRoot) {
  for (const Root root : {Root::kFollow, Root::kStride}) {
    EXPECT_NEAR(Cadence(Mixed({{kOld, 0.5F}}, root), 1.2F), std::sqrt(1.1F), 1e-4F);
    EXPECT_NEAR(Cadence(Mixed({{kOld, 0.5F}, {kActive, 0.5F}}, root), 1.2F), std::sqrt(1.1F * 1.2F),
                1e-4F);
    EXPECT_NEAR(Cadence(Mixed({{0, 1}}, root, kOld), 0.8F), 1 / 1.1F, 1e-4F);
    EXPECT_NEAR(Cadence(Mixed({{kActive, 1}}, root, kOld), 0.8F), 1.2F / 1.1F, 1e-4F);
  }
}

TEST(LogCadenceTest, WhatWasNotMeasuredCountsAsNothing) {
  net::Styles walks = kStyles;
  walks[kOld].run_spm = 0;
  net::Styles bare = kStyles;
  bare[0].walk_spm = bare[0].run_spm = 0;
  net::Styles speedless = kStyles;
  speedless[0].walk_mps = 0;
  const Mixer old = Mixed({{kOld, 1}});
  EXPECT_NEAR(LogCadence(walks, old, 1.2F), std::log(1.1F), 1e-4F);
  EXPECT_EQ(LogCadence(walks, old, 3.1F), 0);
  for (const float speed_mps : {0.0F, 0.8F, 1.2F, 3.0F, 9.0F}) {
    EXPECT_EQ(Cadence(Mixed({}), speed_mps), 1);
    EXPECT_EQ(Cadence(Mixed({{kOdd, 1}}), speed_mps), 1);
    EXPECT_EQ(Cadence(Mixed({{kOdd, 0.5F}, {kOld, 0.5F}}), speed_mps),
              Cadence(Mixed({{kOld, 0.5F}}), speed_mps));
    EXPECT_EQ(LogCadence(bare, old, speed_mps), 0);
    EXPECT_EQ(LogCadence(speedless, old, speed_mps), 0);
    EXPECT_EQ(LogCadence({}, old, speed_mps), 0);
  }
}

TEST(LogCadenceTest, IsBounded) {
  net::Styles wild = kStyles;
  wild[1].walk_spm = 400;
  wild[2].walk_spm = 20;
  EXPECT_NEAR(std::exp(LogCadence(wild, Mixed({{1, 1.5F}}), 1.2F)), tuning::kMostCadence, 1e-4F);
  EXPECT_NEAR(std::exp(LogCadence(wild, Mixed({{2, 1.5F}}), 1.2F)), tuning::kLeastCadence, 1e-4F);
}

// Speed is the length of steps times their cadence: what the two factors share is the style's.
TEST(ChangeOfGaitTest, InWarpedTimeAStrideScalesTheLengthOfSteps) {
  for (const int style : {kActive, kOld, kOdd}) {
    const Mixer stride = Mixed({{style, 1}}), follow = Mixed({{style, 1}}, Root::kFollow);
    for (const float speed_mps : {0.0F, 0.4F, 1.2F, 1.8F, 3.1F}) {
      const float log_speed = LogStride(kStyles, stride, speed_mps);
      const GaitChange live = ChangeOfGait(kStyles, stride, false, speed_mps);
      EXPECT_EQ(live.log_way, log_speed);
      EXPECT_EQ(live.log_cadence, 0);
      const GaitChange warped = ChangeOfGait(kStyles, stride, true, speed_mps);
      EXPECT_EQ(warped.log_cadence, LogCadence(kStyles, stride, speed_mps));
      EXPECT_NEAR(warped.log_way + warped.log_cadence, log_speed, 1e-5F);
      const GaitChange followed = ChangeOfGait(kStyles, follow, true, speed_mps);
      EXPECT_EQ(followed.log_way, 0) << "the way is the performer's";
      EXPECT_EQ(followed.log_cadence, warped.log_cadence);
    }
  }
  const GaitChange old = ChangeOfGait(kStyles, Mixed({{kOld, 1}}), true, 1.2F);
  const float step_m = 0.8F / 121, neutral_step_m = 1.2F / 110;  // per step, in minutes
  EXPECT_NEAR(std::exp(old.log_way), step_m / neutral_step_m, 1e-4F);
}

TEST(ChangeOfGaitTest, StepsAreNoLongerThanAStrideMakesThem) {
  net::Styles wild = kStyles;
  wild[kActive].walk_mps = 15;
  wild[kActive].walk_spm = 60;
  wild[kOld].walk_mps = 0.05F;
  wild[kOld].walk_spm = 300;
  const auto way = [&wild](int style) {
    return std::exp(ChangeOfGait(wild, Mixed({{style, 1}}), true, 1.2F).log_way);
  };
  EXPECT_NEAR(way(kActive), tuning::kMostStride, 1e-4F);
  EXPECT_NEAR(way(kOld), tuning::kLeastStride, 1e-4F);
}

struct StrideTest : testing::Test {
  Stride stride;
  double time_s = 0;
  Vec3 at = Vec3::Zero();

  using Path = std::function<Vec3(double time_s)>;
  // Follows `path` for this long with a factor, calling `each` after every frame.
  void Go(
      const Path& path, double seconds, double rate_hz, float factor,
      const std::function<void()>& each = [] {}) {
    const int frames = static_cast<int>(std::lround(seconds * rate_hz));
    const double from_s = time_s;
    for (int i = started ? 1 : 0; i <= frames; ++i) {
      time_s = from_s + i / rate_hz;
      at = path(time_s);
      stride.Follow(at, started ? 1 / rate_hz : 0, kHole_s, kSettle_s,
                    [factor](float) { return GaitChange{std::log(factor)}; });
      started = true;
      each();
    }
  }
  Vec3 Styled() const { return at + stride.moved_m(); }
  bool started = false;
};

Vec3 Straight(double time_s) { return {0.4F, 0.9F, static_cast<float>(1.2 * time_s)}; }

TEST_F(StrideTest, AWayIsScaledFromWhereItBegan) {
  Go(Straight, 10, 120, 1.25F);
  EXPECT_NEAR(Styled().z(), 1.25 * 12, 0.02);
  EXPECT_NEAR(Styled().x(), 0.4, 1e-5);
  EXPECT_EQ(stride.moved_m().y(), 0) << "heights are the performer's";
  EXPECT_NEAR(stride.speed_mps(), 1.2, 1e-3) << "in the first frames, too";
  EXPECT_NEAR(stride.travel().longer, 0.25, 1e-4);
  EXPECT_NEAR((stride.travel().along - Vec3::UnitZ()).norm(), 0, 1e-3);
}

TEST_F(StrideTest, AStandingPerformerDoesNotDrift) {
  const Mixer mixer = Mixed({{kOld, 1}});
  for (int i = 0; i < 120 * 600; ++i) {
    const double t = i / 120.0;
    const Vec3 sway(static_cast<float>(0.03 * std::sin(1.9 * t)), 0.9F,
                    static_cast<float>(0.02 * std::sin(3.1 * t)));
    stride.Follow(sway, i == 0 ? 0 : 1 / 120.0, kHole_s, kSettle_s, [&mixer](float speed_mps) {
      return GaitChange{LogStride(kStyles, mixer, speed_mps)};
    });
    ASSERT_EQ(stride.moved_m().norm(), 0) << "at " << t << " s";
  }
}

TEST_F(StrideTest, ACircleIsACircleScaledAndItsTurnIsKept) {
  constexpr double kRadius_m = 2, kTurn_s = 10;
  const Path circle = [](double time_s) {
    const double angle = 2 * std::numbers::pi * time_s / kTurn_s;
    return Vec3(static_cast<float>(kRadius_m * std::cos(angle)), 0.9F,
                static_cast<float>(kRadius_m * std::sin(angle)));
  };
  Go(circle, kTurn_s / 4, 120, 0.6F);  // the factor settles
  const Vec3 centre = Styled() - 0.6F * Vec3(at.x(), 0, at.z());
  Go(circle, 5 * kTurn_s, 120, 0.6F, [&] {
    const Vec3 spoke = Styled() - centre;
    EXPECT_NEAR(std::hypot(spoke.x(), spoke.z()), 0.6 * kRadius_m, 1e-3);
    EXPECT_NEAR(std::atan2(spoke.z(), spoke.x()), std::atan2(at.z(), at.x()), 1e-3);
  });
}

TEST_F(StrideTest, ThereAndBackEndsWhereItBegan) {
  const Path pendulum = [](double time_s) {
    return Vec3(0, 0.9F, static_cast<float>(3 * (1 - std::cos(0.4 * time_s))));
  };
  Go(pendulum, 10, 120, 1.3F);
  const Vec3 was = stride.moved_m() - 0.3F * (at - pendulum(0));
  Go(pendulum, 100 * 2 * std::numbers::pi / 0.4 - 10, 120, 1.3F);
  EXPECT_NEAR((stride.moved_m() - 0.3F * (at - pendulum(0)) - was).norm(), 0, 1e-3);
}

TEST_F(StrideTest, SwitchingToFollowKeepsThePlaceAndNothingJumps) {
  Vec3 before = Straight(0);
  float before_mps = 1.2F;
  bool first = true;
  const auto smooth = [&] {
    const float speed_mps = (Styled() - before).norm() * 120;
    if (!first) {
      // 0.3 times 1.2 m/s within some 0.2 s: 3 m/s^2 would be felt as a push.
      EXPECT_LT(std::abs(speed_mps - before_mps) * 120, 3) << "at " << time_s << " s";
    }
    before_mps = first ? 1.2F : speed_mps;
    before = Styled();
    first = false;
  };
  Go(Straight, 3, 120, 1, smooth);
  EXPECT_EQ(stride.moved_m().norm(), 0);
  EXPECT_EQ(stride.factor(), 1);
  Go(Straight, 5, 120, 1.3F, smooth);
  EXPECT_NEAR(stride.factor(), 1.3F, 1e-4F);
  Go(Straight, 5, 120, 1, smooth);
  EXPECT_EQ(stride.factor(), 1) << "exactly, so that bypass is reached";
  const Vec3 kept = stride.moved_m();
  EXPECT_GT(kept.z(), 1.5F);
  Go(Straight, 5, 120, 1, smooth);
  EXPECT_EQ(stride.moved_m(), kept);
  Go(Straight, 5, 120, 0.7F, smooth);
  EXPECT_LT(stride.moved_m().z(), kept.z());
}

TEST_F(StrideTest, AllFrameRatesAgree) {
  const Mixer mixer = Mixed({{kActive, 1}});
  // Stands, walks with the sway of steps, runs, stands.
  const auto path = [](double t) {
    const double walk = std::clamp(t - 1, 0.0, 4.0), run = std::clamp(t - 5, 0.0, 4.0);
    return Vec3(static_cast<float>(0.03 * std::sin(6 * walk)), 0.9F,
                static_cast<float>(1.2 * walk + 3 * run + 0.02 * std::sin(12 * walk)));
  };
  std::vector<float> ends;
  for (const double rate_hz : {24.0, 30.0, 60.0, 120.0, 240.0}) {
    Stride one;
    for (int i = 0; i <= 12 * rate_hz; ++i) {
      one.Follow(
          path(i / rate_hz), i == 0 ? 0 : 1 / rate_hz, kHole_s, kSettle_s,
          [&mixer](float speed_mps) { return GaitChange{LogStride(kStyles, mixer, speed_mps)}; });
    }
    ends.push_back(one.moved_m().z());
  }
  EXPECT_GT(ends.back(), 1.5F);
  for (const float end : ends) EXPECT_NEAR(end, ends.back(), 0.03F * ends.back());
}

// Walks from a stand and stands again: in every frame the speed in warped time is that of a stride.
TEST_F(StrideTest, WayAndCadenceTogetherAreTheStridesSpeed) {
  const Mixer mixer = Mixed({{kOld, 1}});
  Stride live, warped;
  for (int i = 0; i <= 120 * 12; ++i) {
    const double t = i / 120.0, dt_s = i == 0 ? 0 : 1 / 120.0;
    const Vec3 hips(0, 0.9F, static_cast<float>(1.2 * std::clamp(t - 2, 0.0, 6.0)));
    const auto follow = [&](Stride& stride, bool own_cadence) {
      stride.Follow(hips, dt_s, kHole_s, kSettle_s, [&](float speed_mps) {
        return ChangeOfGait(kStyles, mixer, own_cadence, speed_mps);
      });
    };
    follow(live, false);
    follow(warped, true);
    EXPECT_EQ(live.cadence(), 1);
    EXPECT_NEAR(warped.factor() * warped.cadence(), live.factor(), 1e-3F) << t << " s";
    if (t < 2 || t > 10.5) {
      EXPECT_EQ(warped.cadence(), 1) << "standing keeps its time";
    } else if (t > 3.5 && t < 8) {
      EXPECT_NEAR(warped.cadence(), 1.1F, 1e-3F) << t << " s";
    }
  }
}

TEST_F(StrideTest, HolesAndImpossibleStepsAreTakenAsTheyAre) {
  Go(Straight, 2, 120, 1.3F);
  const Vec3 moved = stride.moved_m();
  const auto longer = [](float) { return GaitChange{std::log(1.3F)}; };
  stride.Follow(at + Vec3(0, 0, 0.3F), 0.3, kHole_s, kSettle_s, longer);
  EXPECT_EQ(stride.moved_m(), moved) << "a hole in time";
  stride.Follow(at + Vec3(0.9F, 0, 0.3F), 1 / 120.0, kHole_s, kSettle_s, longer);
  EXPECT_EQ(stride.moved_m(), moved) << "108 m/s";
  stride.Follow(at, 0, kHole_s, kSettle_s, longer);
  EXPECT_EQ(stride.moved_m(), moved) << "no time";
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float bad : {kNaN, kInfinity, -kInfinity, 3e38F}) {
    stride.Follow({bad, 0, bad}, 1 / 120.0, kHole_s, kSettle_s, longer);
    stride.Follow({0, bad, 0}, 1 / 120.0, kHole_s, kSettle_s, longer);
    stride.Follow(at, 1 / 120.0, kHole_s, kSettle_s, longer);
    ASSERT_TRUE(stride.moved_m().allFinite());
    ASSERT_TRUE(std::isfinite(stride.factor()));
    ASSERT_NEAR((stride.moved_m() - moved).norm(), 0, 0.05);
  }
}

// The first velocity would be 0 / 0, and NaN would stay.
TEST_F(StrideTest, FramesNanosecondsApartLeaveNothingBehind) {
  const auto factor = [](float) { return GaitChange{std::log(1.25F)}; };
  stride.Follow(Vec3::Zero(), 0, kHole_s, kSettle_s, factor);
  for (int i = 0; i < 3; ++i) stride.Follow(Vec3::Zero(), 1e-9, kHole_s, kSettle_s, factor);
  EXPECT_EQ(stride.speed_mps(), 0);
  started = true;
  Go(Straight, 5, 120, 1.25F);
  EXPECT_NEAR(stride.speed_mps(), 1.2, 1e-3);
  EXPECT_TRUE(stride.moved_m().allFinite());
}

TEST_F(StrideTest, ANewPlaceBeginsWithoutAnOffset) {
  Go(Straight, 2, 120, 1.3F);
  EXPECT_NE(stride.moved_m().norm(), 0);
  stride.Reset();
  EXPECT_EQ(stride.moved_m().norm(), 0);
  EXPECT_EQ(stride.factor(), 1);
  stride.Follow({5, 1, 5}, 0, kHole_s, kSettle_s, [](float) { return GaitChange{0.3F}; });
  EXPECT_EQ(stride.moved_m().norm(), 0);
}

}  // namespace
}  // namespace styled::stylist
