#include "daemon/decide/admission.h"

#include <gtest/gtest.h>

#include "daemon/runtime/clock.h"

namespace styled::decide {
namespace {

using runtime::kMillisecond_ns;
using runtime::kSecond_ns;

v1::PerformerStats Described(const Admission& admission) {
  v1::PerformerStats stats;
  admission.Describe(stats);
  return stats;
}

TEST(AdmissionTest, ABodyChangesEightTimesAtOnceAndTwiceASecond) {
  Admission admission;
  std::int64_t now_ns = 10 * kSecond_ns;
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(admission.MayChangeBody(now_ns)) << i;
  EXPECT_FALSE(admission.MayChangeBody(now_ns));
  now_ns += 499 * kMillisecond_ns;
  EXPECT_FALSE(admission.MayChangeBody(now_ns));
  now_ns += kMillisecond_ns;
  EXPECT_TRUE(admission.MayChangeBody(now_ns));
  EXPECT_FALSE(admission.MayChangeBody(now_ns));
  now_ns += 3600 * kSecond_ns;
  for (int i = 0; i < 8; ++i) EXPECT_TRUE(admission.MayChangeBody(now_ns)) << "no more is saved up";
  EXPECT_FALSE(admission.MayChangeBody(now_ns));
}

TEST(AdmissionTest, ASlowRigIsStaleAfterThreeOfItsPeriods) {
  Admission admission;
  const std::int64_t stale_ns = 250 * kMillisecond_ns;
  EXPECT_EQ(admission.StaleAfter_ns(stale_ns), stale_ns);
  std::int64_t now_ns = kSecond_ns;
  for (int i = 0; i < 3; ++i) admission.MarkLive(now_ns += kSecond_ns);
  EXPECT_EQ(admission.StaleAfter_ns(stale_ns), 3 * kSecond_ns);
  admission.MarkLive(now_ns += 10 * kMillisecond_ns);
  EXPECT_EQ(admission.StaleAfter_ns(stale_ns), stale_ns) << "the shorter of two intervals counts";
  for (int i = 0; i < 3; ++i) admission.MarkLive(now_ns += 60 * kSecond_ns);
  EXPECT_EQ(admission.StaleAfter_ns(stale_ns), 10 * kSecond_ns) << "at most";
}

TEST(AdmissionTest, TheRateIsThatOfTheFramesAndZeroWhileStale) {
  Admission admission;
  std::int64_t now_ns = kSecond_ns;
  for (int i = 0; i < 61; ++i) admission.MarkLive(now_ns += kSecond_ns / 60);
  EXPECT_TRUE(admission.live());
  EXPECT_EQ(admission.received(), 61U);
  EXPECT_EQ(admission.last_frame_ns(), now_ns);
  admission.Sample(61);
  EXPECT_NEAR(Described(admission).rate_hz(), 60, 0.01) << "60 intervals between 61 frames";
  admission.Sample(0);
  EXPECT_NEAR(Described(admission).rate_hz(), 60, 0.01) << "a slow rig's stays";
  admission.MarkStale();
  EXPECT_EQ(Described(admission).rate_hz(), 0);
  EXPECT_FALSE(Described(admission).live());
}

TEST(AdmissionTest, TheLastRefusalOfASecondIsNamed) {
  Admission admission;
  admission.MarkRefused(runtime::Counter::kPipelineDuplicate);
  admission.MarkRefused(runtime::Counter::kPipelineFarAhead);
  admission.Sample(0);
  EXPECT_EQ(Described(admission).refused(), 2U);
  EXPECT_EQ(Described(admission).refused_as(), "pipeline.far_ahead");
  admission.Sample(0);
  EXPECT_EQ(Described(admission).refused_as(), "");
  EXPECT_EQ(Described(admission).refused(), 2U);
}

}  // namespace
}  // namespace styled::decide
