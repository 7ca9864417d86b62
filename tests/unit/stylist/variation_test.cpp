#include "model/stylist/variation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "model/base/checkpoint_bytes.h"
#include "model/stylist/mixer.h"

namespace styled::stylist {
namespace {

constexpr double kFrame_s = 1.0 / 120;

Settings Vary(int variation, float transition_s = 0.4F, float amount = 1, float drift_s = 0) {
  Settings settings;
  settings.mix[0] = {1, 1};
  settings.variation = variation;
  settings.vary_amount = amount;
  settings.drift_s = drift_s;
  settings.transition_s = transition_s;
  return settings;
}

using Weights = std::map<int, float>;

Weights Of(std::span<const net::VariationWeight> active) {
  Weights weights;
  for (const net::VariationWeight& one : active) {
    EXPECT_GT(one.weight, 0);
    EXPECT_TRUE(weights.emplace(one.variation, one.weight).second) << "each once";
  }
  return weights;
}

// How far apart two points are, and the sum of one.
float Apart(const Weights& a, const Weights& b) {
  float most = 0;
  for (int k = 1; k <= net::kVariations; ++k) {
    const auto weight = [k](const Weights& w) { return w.contains(k) ? w.at(k) : 0.0F; };
    most = std::max(most, std::abs(weight(a) - weight(b)));
  }
  return most;
}
float Sum(const Weights& weights) {
  float sum = 0;
  for (const auto& [variation, weight] : weights) sum += weight;
  return sum;
}

TEST(VariationTest, ADriftOfNextToNoTimeIsNumberedAllTheSame) {
  Variation variation;
  variation.Aim(Vary(7, 0, 1, 1e-38F), false);
  for (int i = 0; i < 100; ++i) variation.Advance(kFrame_s);
  EXPECT_NEAR(Sum(Of(variation.in_force())), 1, 1e-3);
  const auto bytes = CheckpointBytes([&](Checkpoint& c) { variation.Carry(c); });
  Checkpoint c = Checkpoint::From(bytes);
  Variation(variation).Carry(c);
  EXPECT_TRUE(c.complete());
}

TEST(VariationTest, WithoutOneTheStyleIsShownItself) {
  Variation variation;
  variation.Aim(Vary(0), false);
  variation.Advance(kFrame_s);
  EXPECT_TRUE(variation.in_force().empty());
  variation.Aim(Vary(7, 0.4F, 0), false);
  for (int i = 0; i < 100; ++i) variation.Advance(kFrame_s);
  EXPECT_TRUE(variation.in_force().empty()) << "an amount of 0";
}

TEST(VariationTest, AnotherOneIsCrossFadedAndSoIsTheWayBack) {
  Variation variation;
  variation.Aim(Vary(7, 0.4F, 0.8F), true);
  variation.Advance(0);
  EXPECT_EQ(Of(variation.in_force()), (Weights{{7, 0.8F}})) << "at once";
  EXPECT_FALSE(variation.fading());
  variation.Aim(Vary(9, 0.4F, 0.8F), false);
  Weights last = Of(variation.in_force());
  for (int i = 0; i < 24; ++i) {
    variation.Advance(kFrame_s);
    const Weights now = Of(variation.in_force());
    EXPECT_LT(Apart(now, last), 0.03F);
    EXPECT_NEAR(Sum(now), 0.8F, 1e-6F);
    last = now;
  }
  EXPECT_TRUE(variation.fading());
  EXPECT_NEAR(last.at(7), 0.4F, 1e-6F);
  EXPECT_NEAR(last.at(9), 0.4F, 1e-6F);
  // A third one meanwhile begins where the fade is.
  variation.Aim(Vary(0, 0.4F, 0.8F), false);
  variation.Advance(1e-6);
  EXPECT_LT(Apart(Of(variation.in_force()), last), 1e-4F);
  for (int i = 0; i < 49; ++i) variation.Advance(kFrame_s);
  EXPECT_TRUE(variation.in_force().empty());
  EXPECT_FALSE(variation.fading());
}

TEST(VariationTest, TheAmountFadesAndReachesWhatWasAskedFor) {
  Variation variation;
  variation.Aim(Vary(3), true);
  variation.Advance(0);
  variation.Aim(Vary(3, 0.4F, 1.5F), false);
  variation.Advance(0.2);
  EXPECT_EQ(Of(variation.in_force()), (Weights{{3, 1.25F}}));
  variation.Advance(0.3);
  EXPECT_EQ(Of(variation.in_force()), (Weights{{3, 1.5F}}));
}

TEST(VariationTest, HastyChangesNeverJump) {
  Variation variation;
  variation.Aim(Vary(1), true);
  variation.Advance(0);
  Weights last = Of(variation.in_force());
  for (int round = 0; round < 500; ++round) {  // a slider
    variation.Aim(Vary(1 + (round * 37) % net::kVariations, 5), false);
    variation.Advance(kFrame_s);
    variation.Advance(kFrame_s);
    const Weights now = Of(variation.in_force());
    EXPECT_LT(Apart(now, last), 1e-3F);
    EXPECT_LE(Sum(now), 1.0001F);
    last = now;
  }
}

// The largest change of a weight from one frame to the next, of its slope, and of that.
struct Steps {
  float first = 0, second = 0, third = 0;
};
Steps StepsOf(const std::vector<Weights>& path) {
  Steps steps;
  for (int k = 1; k <= net::kVariations; ++k) {
    const auto at = [&](std::size_t i) { return path[i].contains(k) ? path[i].at(k) : 0.0F; };
    for (std::size_t i = 3; i < path.size(); ++i) {
      const float a = at(i) - at(i - 1), b = at(i - 1) - at(i - 2), c = at(i - 2) - at(i - 3);
      steps.first = std::max(steps.first, std::abs(a));
      steps.second = std::max(steps.second, std::abs(a - b));
      steps.third = std::max(steps.third, std::abs((a - b) - (b - c)));
    }
  }
  return steps;
}

TEST(VariationTest, WanderingBeginsAtTheVariationAndIsSmooth) {
  for (const int variation_number : {0, 7}) {
    Variation variation;
    variation.Aim(Vary(variation_number), true);
    variation.Advance(0);
    std::vector<Weights> path{Of(variation.in_force())};
    variation.Aim(Vary(variation_number, 0.4F, 1, 2), false);
    std::set<int> seen;
    for (int i = 0; i < 120 * 60; ++i) {
      variation.Advance(kFrame_s);
      path.push_back(Of(variation.in_force()));
      EXPECT_LE(Sum(path.back()), 1.0001F);
      for (const auto& [k, weight] : path.back()) {
        if (weight > 0.5F) seen.insert(k);
      }
    }
    EXPECT_LT(Apart(path[0], path[1]), 1e-3F) << "without a jump";
    // A knot takes two seconds: slope at most 1 / knot, its change at most 2 / knot².
    const Steps steps = StepsOf(path);
    EXPECT_LT(steps.first, 1.1F * static_cast<float>(kFrame_s) / 2);
    EXPECT_LT(steps.second, 2.2F * static_cast<float>(kFrame_s * kFrame_s) / 4 + 1e-6F);
    EXPECT_LT(steps.third, steps.second / 10) << "its curvature is continuous, too";
    EXPECT_GE(seen.size(), 20U) << "about one each two seconds";
    EXPECT_LE(seen.size(), 31U);
    EXPECT_EQ(seen.contains(0), false);
  }
}

TEST(VariationTest, AReplayWandersTheSameWayAndAnotherSeedAnother) {
  const auto walk = [](int number, bool interrupted) {
    Variation variation;
    variation.Aim(Vary(number, 0.4F, 1, 1), true);
    for (int i = 0; i < 3000; ++i) {
      variation.Advance(kFrame_s);
      // Settings that leave it as it is do not disturb it.
      if (interrupted && i % 50 == 0) variation.Aim(Vary(number, 0.1F, 1, 1), false);
    }
    return Of(variation.in_force());
  };
  EXPECT_EQ(walk(7, false), walk(7, false));
  EXPECT_EQ(walk(7, false), walk(7, true));
  EXPECT_NE(walk(7, false), walk(8, false));
}

TEST(VariationTest, ItStopsAtTheVariationByAFadeAndItsPaceChangesWithoutOne) {
  Variation variation;
  variation.Aim(Vary(7, 0.4F, 1, 1), true);
  for (int i = 0; i < 2000; ++i) variation.Advance(kFrame_s);
  Weights last = Of(variation.in_force());
  EXPECT_FALSE(last.contains(7));
  variation.Aim(Vary(7, 0.4F, 1, 60), false);
  variation.Advance(1e-6);
  EXPECT_LT(Apart(Of(variation.in_force()), last), 1e-4F);
  EXPECT_FALSE(variation.fading());
  last = Of(variation.in_force());
  variation.Aim(Vary(7, 0.4F, 1, 0), false);
  variation.Advance(1e-6);
  EXPECT_LT(Apart(Of(variation.in_force()), last), 1e-4F);
  variation.Advance(0.5);
  EXPECT_EQ(Of(variation.in_force()), (Weights{{7, 1.0F}}));
}

TEST(VariationTest, ThePaceHasALimitAndAClockThatGoesBackDoesNoHarm) {
  Variation variation;
  variation.Aim(Vary(7, 0.4F, 1, 1e-6F), true);
  variation.Advance(0);
  Weights last = Of(variation.in_force());
  for (int i = 0; i < 1000; ++i) {
    variation.Advance(kFrame_s);
    EXPECT_LT(Apart(Of(variation.in_force()), last), 0.02F);
    last = Of(variation.in_force());
  }
  variation.Advance(-1e9);
  variation.Advance(1e15);
  EXPECT_LE(Sum(Of(variation.in_force())), 1.0001F);
}

TEST(VariationTest, AMixerSetsItAtOnceWhereNoStyleIsInEffectAndElseFades) {
  Mixer mixer;
  mixer.Advance(0);
  mixer.Aim(Vary(7));
  mixer.Advance(0.1);
  EXPECT_EQ(Of(mixer.variations()), (Weights{{7, 1.0F}})) << "there is no style that could change";
  mixer.Advance(1);
  EXPECT_FALSE(mixer.fading());
  mixer.Aim(Vary(8, 10));
  mixer.Advance(0.1);
  Settings other = Vary(8, 0.1F);
  other.mix[0] = {2, 1};
  mixer.Aim(other);
  mixer.Advance(0.2);
  EXPECT_EQ(mixer.in_force().size(), 1U) << "its own fade is over";
  EXPECT_TRUE(mixer.fading()) << "that of the variation goes on";
  EXPECT_TRUE(Of(mixer.variations()).contains(7));
}

}  // namespace
}  // namespace styled::stylist
