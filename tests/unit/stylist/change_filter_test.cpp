#include "model/stylist/change_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

constexpr double kDt_s = 1.0 / 120;

StyleDelta All(float value) { return StyleDelta::Constant(value); }

struct ChangeFilterTest : testing::Test {
  Options options;
  Mixer mixer;
  ChangeFilter filter;

  void Style(float transition_s, int style = 1) {
    Settings settings;
    settings.mix[0] = {style, 1.0F};
    settings.transition_s = transition_s;
    mixer.Aim(settings);
  }
  void Feed(const StyleDelta& target, int frames, float reconstruction_rad = 0.1F) {
    for (int i = 0; i < frames; ++i) {
      mixer.Advance(kDt_s);
      filter.Follow(target, kDt_s, reconstruction_rad, mixer, options);
      filter.Apply(filter.value(), kDt_s, options);
    }
  }
};

TEST_F(ChangeFilterTest, TheFirstFrameTakesItsTargetAtOnceAndLaterOnesFollow) {
  Style(0);
  Feed(All(0.2F), 1);
  EXPECT_EQ(filter.applied(), All(0.2F));
  EXPECT_EQ(filter.delay_s(), 0);
  Feed(All(0.4F), 1);
  EXPECT_LT(filter.applied()(0, 0), 0.25F);
  Feed(All(0.4F), 120);
  EXPECT_NEAR(filter.applied()(0, 0), 0.4F, 1e-3F);
}

TEST_F(ChangeFilterTest, AfterAStartTheDelayIsLongerForHalfASecond) {
  Style(0);
  const auto expect = [this](const char* when) {
    Feed(All(0), 1);
    Feed(All(0.2F), 1);
    EXPECT_NEAR(filter.delay_s(), 3 * options.change_tau_s, 1e-3F) << when;
    Feed(All(0.2F), 29);
    EXPECT_NEAR(filter.delay_s(), 2 * options.change_tau_s, 3e-3F) << when;
    Feed(All(0.2F), 31);
    EXPECT_FLOAT_EQ(filter.delay_s(), options.change_tau_s) << when;
  };
  expect("at first");
  filter.Restart(true);
  expect("after a restart");
}

TEST_F(ChangeFilterTest, ABadReconstructionMakesTheDelayFiveTimesAsLong) {
  Style(0);
  Feed(All(0.2F), 120, 0.6F);
  EXPECT_NEAR(filter.delay_s(), 5 * options.change_tau_s, 1e-3F);
  Feed(All(0.2F), 120, 0.1F);
  EXPECT_NEAR(filter.delay_s(), options.change_tau_s, 1e-3F);
}

TEST_F(ChangeFilterTest, ASwitchIsDelayedByHowFarALimbHasToGo) {
  Style(0);
  Feed(All(0), 120);
  Style(0.2F, 2);
  StyleDelta arm = All(0);
  arm(0, body::kLeftUpperArm) = 2.5F;
  Feed(arm, 1);
  // From the shoulder's joint to the finger tips: 0.27 + 0.25 + 0.1 m.
  const float least_s = std::sqrt(2.5F * 0.62F / tuning::kSwitchAcceleration_mps2);
  EXPECT_NEAR(filter.delay_s(), least_s, 1e-3F);
  EXPECT_GT(filter.delay_s(), 2 * options.change_tau_s);
}

TEST_F(ChangeFilterTest, ANearStyleAndACutAreNotDelayed) {
  Style(0);
  Feed(All(0), 120);
  Style(0.2F, 2);
  StyleDelta hand = All(0);
  hand(0, body::kLeftHand) = 0.5F;
  Feed(hand, 1);
  EXPECT_FLOAT_EQ(filter.delay_s(), options.change_tau_s) << "5 cm";
  StyleDelta arm = All(0);
  arm(0, body::kLeftUpperArm) = 1.5F;
  Feed(arm, 60);
  Style(0);
  filter.EndSwitch();
  Feed(All(0), 1);
  EXPECT_FLOAT_EQ(filter.delay_s(), options.change_tau_s) << "a cut";
}

TEST_F(ChangeFilterTest, ARestartIsFadedOver) {
  Style(0);
  Feed(All(0.2F), 10);
  filter.Restart(true);
  Feed(All(0.6F), 1);
  EXPECT_NEAR(filter.applied()(0, 0), 0.2F, 1e-3F);
  Feed(All(0.6F), static_cast<int>(0.5F * options.restart_fade_s / kDt_s));
  EXPECT_NEAR(filter.applied()(0, 0), 0.4F, 0.02F) << "half way";
  Feed(All(0.6F), 30);
  EXPECT_FLOAT_EQ(filter.applied()(0, 0), 0.6F);
  filter.Restart(false);
  Feed(All(0.1F), 1);
  EXPECT_EQ(filter.applied(), All(0.1F)) << "and not, where nothing was applied before";
}

TEST_F(ChangeFilterTest, WhereEveryFrameComesAfterAGapTheStyleArrives) {
  Style(0);
  Feed(All(0), 10);
  for (int frame = 0; frame < 5; ++frame) {
    filter.RestartAfterGap(true, 1.0, options);
    filter.Follow(All(0.5F), 1.0, 0.1F, mixer, options);
    filter.Apply(filter.value(), 1.0, options);
  }
  EXPECT_FLOAT_EQ(filter.applied()(0, 0), 0.5F);
}

TEST_F(ChangeFilterTest, ClearedItFadesInFromNone) {
  Style(0);
  Feed(All(0.5F), 10);
  filter.Clear();
  EXPECT_TRUE(filter.applied().isZero(0));
  Feed(All(0.5F), 1);
  EXPECT_NEAR(filter.applied()(0, 0), 0, 1e-3F);
  Feed(All(0.5F), 60);
  EXPECT_NEAR(filter.applied()(0, 0), 0.5F, 1e-3F);
}

}  // namespace
}  // namespace styled::stylist
