#include "daemon/perform/performer/latency.h"

#include <gtest/gtest.h>

namespace styled::pipeline {
namespace {

using runtime::kMillisecond_ns;
using runtime::kSecond_ns;

v1::PerformerStats StatsOf(const Latency& latency) {
  v1::PerformerStats stats;
  latency.Describe(stats);
  return stats;
}

TEST(RigPeriodTest, IsThatOf120HzUntilFramesFollowEachOther) {
  RigPeriod rig;
  EXPECT_EQ(rig.period_ns(), kSecond_ns / 120);
  rig.NoteFrame(7, 0);
  rig.NoteFrame(9, 40 * kMillisecond_ns);  // one is missing between
  EXPECT_EQ(rig.period_ns(), kSecond_ns / 120);
  rig.NoteFrame(10, 60 * kMillisecond_ns);
  EXPECT_EQ(rig.period_ns(), 20 * kMillisecond_ns);
}

TEST(RigPeriodTest, LossesBodiesPausesAndNewSessionsDoNotLengthenIt) {
  RigPeriod rig;
  std::uint64_t sequence = 0;
  std::int64_t elapsed_ns = 0;
  for (int i = 0; i < 1000; ++i) {
    elapsed_ns += 20 * kMillisecond_ns;
    sequence += i % 50 == 0 ? 2 : 1;  // a body before
    if (i % 7 != 0) rig.NoteFrame(sequence, elapsed_ns);
    if (i == 500) elapsed_ns = 0;
    if (i == 700) elapsed_ns += 5 * kSecond_ns;
  }
  EXPECT_EQ(rig.period_ns(), 20 * kMillisecond_ns);
}

TEST(RigPeriodTest, AClockOfWholeMillisecondsGivesTheMean) {
  RigPeriod rig;
  for (std::uint64_t i = 0; i < 600; ++i) {
    rig.NoteFrame(i, static_cast<std::int64_t>(i * 1000 / 120) * kMillisecond_ns);
  }
  EXPECT_NEAR(static_cast<double>(rig.period_ns()), 1e9 / 120, 0.04e6);
}

TEST(RigPeriodTest, ItFollowsARigThatIsSetToAnotherRate) {
  RigPeriod rig;
  std::int64_t elapsed_ns = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    elapsed_ns += i < 200 ? 8 * kMillisecond_ns : 16 * kMillisecond_ns;
    rig.NoteFrame(i, elapsed_ns);
  }
  EXPECT_NEAR(static_cast<double>(rig.period_ns()), 16e6, 0.1e6);
}

TEST(LatencyTest, AFrameThatTakesLongerThanThePeriodIsCounted) {
  Latency latency;
  EXPECT_FALSE(latency.Add(8 * kMillisecond_ns));
  EXPECT_TRUE(latency.Add(9 * kMillisecond_ns));
  latency.rig.NoteFrame(1, 0);
  latency.rig.NoteFrame(2, 10 * kMillisecond_ns);
  EXPECT_FALSE(latency.Add(9 * kMillisecond_ns));
  EXPECT_EQ(StatsOf(latency).over_budget(), 1U);
  EXPECT_FLOAT_EQ(StatsOf(latency).period_ms(), 10);
}

// The last second looks well again at once; the minute and the whole do not.
TEST(LatencyTest, ABadSecondStaysInTheMinuteForAMinuteAndInTheWholeForEver) {
  Latency latency;
  std::int64_t now_ns = 0;
  const auto second = [&](std::int64_t latency_ns) {
    for (int i = 0; i < 120; ++i) latency.Add(latency_ns);
    now_ns += kSecond_ns;
    latency.Sample(true, now_ns);
  };
  for (int i = 0; i < 5; ++i) second(kMillisecond_ns / 10);
  second(20 * kMillisecond_ns);
  EXPECT_GT(StatsOf(latency).latency_p99_us(), 19'000);
  for (int i = 0; i < 50; ++i) second(kMillisecond_ns / 10);
  EXPECT_LT(StatsOf(latency).latency_p99_us(), 120);
  EXPECT_NEAR(StatsOf(latency).latency_p99_minute_us(), 20'000, 2'600);
  EXPECT_NEAR(StatsOf(latency).latency_p99_overall_us(), 20'000, 2'600);
  for (int i = 0; i < 40; ++i) second(kMillisecond_ns / 10);
  EXPECT_LT(StatsOf(latency).latency_p99_minute_us(), 120) << "90 s have passed";
  EXPECT_NEAR(StatsOf(latency).latency_p99_overall_us(), 20'000, 2'600);
}

TEST(LatencyTest, ASlowRigKeepsTheValuesOfItsLastFrame) {
  Latency latency;
  latency.Add(kMillisecond_ns);
  latency.Sample(true, kSecond_ns);
  latency.Sample(true, 2 * kSecond_ns);
  EXPECT_GT(StatsOf(latency).latency_p99_us(), 990);
  latency.Sample(false, 3 * kSecond_ns);
  EXPECT_EQ(StatsOf(latency).latency_p99_us(), 0);
}

TEST(LatencyTest, APerformerNeedsLittleMemoryForThem) { EXPECT_LE(sizeof(Latency), 3200U); }

}  // namespace
}  // namespace styled::pipeline
