#include "model/stylist/interleaver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace styled::stylist {
namespace {

struct Step {
  int frame, state;
  float share;
};

std::vector<Step> Feed(Interleaver& interleaver, const std::vector<double>& times_s) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    EXPECT_TRUE(interleaver.Begin(std::llround(times_s[i] * 1e9), 30.0F));
    Interleaver::Tick tick;
    while (interleaver.Next(tick)) steps.push_back({static_cast<int>(i), tick.state, tick.share});
  }
  return steps;
}

std::vector<double> Regular(double rate_hz, int frames, double start_s = 5.0) {
  std::vector<double> times;
  for (int i = 0; i < frames; ++i) times.push_back(start_s + i / rate_hz);
  return times;
}

TEST(InterleaverTest, AtFourTimesTheNetworksRateFourStatesTakeTurnsOnTheFramesThemselves) {
  Interleaver interleaver;
  const auto steps = Feed(interleaver, Regular(120, 40));
  // Until the rate is known, only the first state is stepped, at its own ticks.
  ASSERT_EQ(steps.size(), 35U);
  EXPECT_EQ(steps[0].frame, 0);
  EXPECT_EQ(steps[1].frame, 4);
  EXPECT_EQ(steps[0].state + steps[1].state, 0);
  for (int i = 7; i < 40; ++i) {
    const Step& step = steps[static_cast<std::size_t>(i - 5)];
    EXPECT_EQ(step.frame, i);
    EXPECT_EQ(step.state, i % 4);
    EXPECT_EQ(step.share, 1.0F);
  }
}

TEST(InterleaverTest, EveryStateIsSteppedAtTheNetworksRateWhateverTheStreams) {
  for (double rate_hz : {24.0, 25.0, 30.0, 50.0, 59.94, 60.0, 90.0, 100.0, 119.88, 120.0, 240.0}) {
    Interleaver interleaver;
    const int frames = static_cast<int>(rate_hz * 10);
    const auto steps = Feed(interleaver, Regular(rate_hz, frames));
    const double per_state = static_cast<double>(steps.size()) / interleaver.interleaved();
    EXPECT_NEAR(per_state, 300, 3) << rate_hz << " Hz";
  }
}

TEST(InterleaverTest, AMissedTickIsMadeUpByInterpolationInOrder) {
  Interleaver interleaver;
  auto times = Regular(120, 20);
  times.erase(times.begin() + 10, times.begin() + 13);
  const auto steps = Feed(interleaver, times);
  ASSERT_EQ(steps.size(), 15U);
  const auto at = [&steps](int tick) { return steps[static_cast<std::size_t>(tick - 5)]; };
  for (int tick = 7; tick < 20; ++tick) EXPECT_EQ(at(tick).state, tick % 4);
  EXPECT_EQ(at(10).frame, 10);
  EXPECT_NEAR(at(10).share, 0.25F, 1e-3F);
  EXPECT_NEAR(at(12).share, 0.75F, 1e-3F);
  EXPECT_EQ(at(13).share, 1.0F);
}

TEST(InterleaverTest, AnUnevenFirstIntervalDoesNotDecideTheRate) {
  Interleaver interleaver;
  auto times = Regular(120, 30);
  times[1] += 0.004;
  times[2] += 0.002;
  Feed(interleaver, times);
  EXPECT_EQ(interleaver.interleaved(), 4);
}

TEST(InterleaverTest, JitterWithinAFifthOfAPeriodIsSnapped) {
  Interleaver interleaver;
  auto times = Regular(120, 100);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] += (i % 3 == 0 ? 1 : -1) * 0.0007;
  for (const Step& step : Feed(interleaver, times)) EXPECT_EQ(step.share, 1.0F);
}

TEST(InterleaverTest, AChangedRateIsReportedOnceItHasLasted) {
  Interleaver interleaver;
  Feed(interleaver, Regular(120, 50, 0));
  bool changed = false;
  for (int i = 1; i <= 20 && !changed; ++i) {
    changed = !interleaver.Begin(std::llround((49 / 120.0 + i / 60.0) * 1e9), 30.0F);
  }
  EXPECT_TRUE(changed);
  interleaver.Restart();
  Feed(interleaver, Regular(60, 9, 2));
  EXPECT_EQ(interleaver.interleaved(), 2);
}

// Restarts as the stylist does if Begin returns false. The times are arbitrary.
TEST(InterleaverTest, NoSequenceOfTimesRunsMoreThanTheStatedTicks) {
  std::mt19937_64 random(4);
  for (int clock = 0; clock < 2000; ++clock) {
    Interleaver interleaver;
    std::int64_t time_ns = 0;
    int all = 0, frames = 0;
    const double most = 7 + static_cast<double>(random() % 800) / 100;
    for (; frames < 100; ++frames) {
      const double exponent = std::fmod(static_cast<double>(random() % 10000) / 1000, most) + 3;
      time_ns += static_cast<std::int64_t>(std::pow(10.0, exponent));
      if (!interleaver.Begin(time_ns, 30.0F)) {
        interleaver.Restart();
        ASSERT_TRUE(interleaver.Begin(time_ns, 30.0F));
      }
      Interleaver::Tick tick;
      int ran = 0;
      while (ran <= kMaxStepsPerFrame && interleaver.Next(tick)) ++ran;
      ASSERT_LE(ran, kMaxStepsPerFrame);
      all += ran;
    }
    ASSERT_LE(all, kMaxStepsPerFrame + kMeanStepsPerFrame * frames);
  }
}

}  // namespace
}  // namespace styled::stylist
