#include "model/stylist/mixer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace styled::stylist {
namespace {

Settings Of(std::initializer_list<net::StyleWeight> mix, float transition_s = 0.4F) {
  Settings settings;
  std::copy(mix.begin(), mix.end(), settings.mix.begin());
  settings.transition_s = transition_s;
  return settings;
}

float WeightOf(const Mixer& mixer, int style) {
  for (const net::StyleWeight& active : mixer.in_force()) {
    if (active.style == style) return active.weight;
  }
  return -1;
}

TEST(MixerTest, TheFirstFrameShowsTheStyleAtOnce) {
  Mixer mixer;
  mixer.Aim(Of({{2, 1.0F}}, 10.0F));
  mixer.Advance(0.0);
  EXPECT_EQ(WeightOf(mixer, 2), 1.0F);
  EXPECT_FALSE(mixer.fading());
}

TEST(MixerTest, ALaterStyleFadesInOverTheTransitionAndShowsFromItsFirstFrame) {
  Mixer mixer;
  mixer.Advance(0.0);
  EXPECT_TRUE(mixer.empty());
  mixer.Aim(Of({{2, 1.0F}}, 0.4F));
  mixer.Advance(0.1);
  EXPECT_GT(WeightOf(mixer, 2), 0.0F);
  mixer.Advance(0.1);
  EXPECT_FLOAT_EQ(WeightOf(mixer, 2), 0.5F);
  mixer.Advance(0.2001);
  EXPECT_EQ(WeightOf(mixer, 2), 1.0F);
  EXPECT_FALSE(mixer.fading());
}

TEST(MixerTest, ANewCommandStartsFromTheWeightsInForce) {
  Mixer mixer;
  mixer.Aim(Of({{1, 1.0F}}));
  mixer.Advance(0.0);
  mixer.Aim(Of({{2, 1.0F}}, 1.0F));
  mixer.Advance(0.5);
  EXPECT_FLOAT_EQ(WeightOf(mixer, 1), 0.5F);
  EXPECT_FLOAT_EQ(WeightOf(mixer, 2), 0.5F);
  mixer.Aim(Of({{1, 1.0F}}, 1.0F));
  mixer.Advance(1e-6);
  EXPECT_NEAR(WeightOf(mixer, 1), 0.5F, 1e-4F);
  EXPECT_NEAR(WeightOf(mixer, 2), 0.5F, 1e-4F);
}

TEST(MixerTest, ABranchIsDroppedAtWeightZero) {
  Mixer mixer;
  mixer.Aim(Of({{1, 1.0F}}));
  mixer.Advance(0.0);
  mixer.Aim(Of({}, 0.2F));
  mixer.Advance(0.1);
  EXPECT_EQ(mixer.in_force().size(), 1U);
  mixer.Advance(0.2);
  EXPECT_TRUE(mixer.empty());
}

TEST(MixerTest, StrengthScalesTheMixAndZeroMeansNone) {
  Mixer mixer;
  Settings settings = Of({{1, 0.5F}, {2, 0.5F}});
  settings.strength = 0.8F;
  mixer.Aim(settings);
  mixer.Advance(0.0);
  EXPECT_FLOAT_EQ(WeightOf(mixer, 1), 0.4F);
  settings.strength = 0;
  settings.transition_s = 0;
  mixer.Aim(settings);
  mixer.Advance(0.01);
  EXPECT_TRUE(mixer.empty());
}

TEST(MixerTest, HastyCommandsNeverAskForMoreBranchesThanThereAre) {
  Mixer mixer;
  mixer.Advance(0.0);
  for (int round = 0; round < 50; ++round) {
    const int first = 1 + (round * 4) % 28;
    mixer.Aim(
        Of({{first, 0.25F}, {first + 1, 0.25F}, {first + 2, 0.25F}, {first + 3, 0.25F}}, 5.0F));
    mixer.Advance(0.01);
    EXPECT_LE(mixer.in_force().size(), static_cast<std::size_t>(net::kMaxActive));
    for (int style = first; style < first + 4; ++style) EXPECT_GE(WeightOf(mixer, style), 0.0F);
  }
}

TEST(MixerTest, PartsFadeWithTheStyleThatIsInForceAndAreSetAtOnceWhenNoneIs) {
  Mixer mixer;
  mixer.Advance(0.0);
  Settings arms = Of({{1, 1.0F}}, 0.4F);
  arms.parts = *body::FindParts("arms");
  mixer.Aim(arms);
  mixer.Advance(0.1);
  EXPECT_EQ(mixer.share(body::Part::kLeftArm), 1.0F);
  EXPECT_EQ(mixer.share(body::Part::kHead), 0.0F) << "there is no style that could fade out";
  EXPECT_FALSE(mixer.whole());
  mixer.Advance(1.0);
  mixer.Aim(Of({{1, 1.0F}}, 0.4F));  // the whole body
  mixer.Advance(0.2);
  EXPECT_FLOAT_EQ(mixer.share(body::Part::kHead), 0.5F);
  EXPECT_FLOAT_EQ(WeightOf(mixer, 1), 1.0F);
  mixer.Advance(0.2001);
  EXPECT_TRUE(mixer.whole());
}

}  // namespace
}  // namespace styled::stylist
