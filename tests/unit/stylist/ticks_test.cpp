#include "model/stylist/ticks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace styled::stylist {
namespace {

struct Step {
  int frame, state;
  float share;
};

std::vector<Step> Feed(Ticks& ticks, const std::vector<double>& times_s) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    EXPECT_TRUE(ticks.Begin(std::llround(times_s[i] * 1e9), 30.0F));
    Ticks::Tick tick;
    while (ticks.Next(tick)) steps.push_back({static_cast<int>(i), tick.state, tick.share});
  }
  return steps;
}

std::vector<double> Regular(double rate_hz, int frames, double start_s = 5.0) {
  std::vector<double> times;
  for (int i = 0; i < frames; ++i) times.push_back(start_s + i / rate_hz);
  return times;
}

TEST(TicksTest, AtFourTimesTheNetworksRateFourStatesTakeTurnsOnTheFramesThemselves) {
  Ticks ticks;
  const auto steps = Feed(ticks, Regular(120, 40));
  ASSERT_EQ(steps.size(), 40U);
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(steps[static_cast<std::size_t>(i)].frame, i);
    EXPECT_EQ(steps[static_cast<std::size_t>(i)].state, i % 4);
    EXPECT_EQ(steps[static_cast<std::size_t>(i)].share, 1.0F);
  }
}

TEST(TicksTest, EveryStateIsSteppedAtTheNetworksRateWhateverTheStreams) {
  for (double rate_hz : {24.0, 25.0, 30.0, 50.0, 59.94, 60.0, 90.0, 100.0, 119.88, 120.0, 240.0}) {
    Ticks ticks;
    const int frames = static_cast<int>(rate_hz * 10);
    const auto steps = Feed(ticks, Regular(rate_hz, frames));
    const double per_state = static_cast<double>(steps.size()) / ticks.interleaved();
    EXPECT_NEAR(per_state, 300, 3) << rate_hz << " Hz";
  }
}

TEST(TicksTest, AMissedTickIsMadeUpByInterpolationInOrder) {
  Ticks ticks;
  auto times = Regular(120, 20);
  times.erase(times.begin() + 10, times.begin() + 13);
  const auto steps = Feed(ticks, times);
  ASSERT_EQ(steps.size(), 20U);
  for (std::size_t i = 0; i < steps.size(); ++i) EXPECT_EQ(steps[i].state, static_cast<int>(i % 4));
  EXPECT_EQ(steps[10].frame, 10);
  EXPECT_NEAR(steps[10].share, 0.25F, 1e-3F);
  EXPECT_NEAR(steps[12].share, 0.75F, 1e-3F);
  EXPECT_EQ(steps[13].share, 1.0F);
}

TEST(TicksTest, JitterWithinAFifthOfAPeriodIsSnapped) {
  Ticks ticks;
  auto times = Regular(120, 100);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] += (i % 3 == 0 ? 1 : -1) * 0.0007;
  for (const Step& step : Feed(ticks, times)) EXPECT_EQ(step.share, 1.0F);
}

TEST(TicksTest, AChangedRateIsReportedOnceItHasLasted) {
  Ticks ticks;
  Feed(ticks, Regular(120, 50, 0));
  bool changed = false;
  for (int i = 1; i <= 20 && !changed; ++i) {
    changed = !ticks.Begin(std::llround((49 / 120.0 + i / 60.0) * 1e9), 30.0F);
  }
  EXPECT_TRUE(changed);
  ticks.Restart();
  Feed(ticks, Regular(60, 5, 2));
  EXPECT_EQ(ticks.interleaved(), 2);
}

}  // namespace
}  // namespace styled::stylist
