#include "daemon/pipeline/session.h"

#include <gtest/gtest.h>

#include "daemon/pipeline/schedule.h"

namespace styled::pipeline {
namespace {

using Arrival = Session::Arrival;
using Time = Session::Time;
constexpr std::int64_t kMs = 1'000'000;
const SessionRules kRules;

TEST(SessionTest, FirstDatagramStartsASessionAndCountsNothingLost) {
  Session session;
  EXPECT_EQ(session.Admit(1, 500, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.lost(), 0U);
}

TEST(SessionTest, SequenceTellsDuplicatesReorderedAndLostApart) {
  Session session;
  EXPECT_EQ(session.Admit(1, 10, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(1, 10, 1, kRules), Arrival::kDuplicate);
  EXPECT_EQ(session.Admit(1, 13, 2, kRules), Arrival::kNext);
  EXPECT_EQ(session.lost(), 2U);
  EXPECT_EQ(session.Admit(1, 12, 3, kRules), Arrival::kReordered);
  EXPECT_EQ(session.Admit(1, 12, 4, kRules), Arrival::kDuplicate);
  EXPECT_EQ(session.Admit(1, 10, 5, kRules), Arrival::kDuplicate);
  EXPECT_EQ(session.Admit(1, 9, 5, kRules), Arrival::kReordered);
  EXPECT_EQ(session.Admit(1, 200, 6, kRules), Arrival::kNext);
  EXPECT_EQ(session.Admit(1, 13, 7, kRules), Arrival::kReordered) << "too old to tell";
  EXPECT_EQ(session.Admit(1, ~0ULL, 8, kRules), Arrival::kNext);
  EXPECT_EQ(session.Admit(1, 0, 9, kRules), Arrival::kReordered);
}

TEST(SessionTest, ASecondSenderWaitsForTheFirstToBeSilent) {
  Session session;
  EXPECT_EQ(session.Admit(1, 0, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(4, 0, 99 * kMs, kRules), Arrival::kSecondSender);
  EXPECT_EQ(session.Admit(1, 1, 99 * kMs, kRules), Arrival::kNext);
  EXPECT_EQ(session.Admit(4, 1, 198 * kMs, kRules), Arrival::kSecondSender);
  EXPECT_EQ(session.Admit(4, 2, 199 * kMs, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(1, 2, 200 * kMs, kRules), Arrival::kSecondSender) << "roles changed";
  EXPECT_EQ(session.lost(), 0U);
}

TEST(SessionTest, TheSameSenderBeginsAnewAtOnce) {
  Session session;
  EXPECT_EQ(session.Admit(7, 0, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(7 + kSessionStep, 0, 1 * kMs, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(7, 1, 2 * kMs, kRules), Arrival::kSecondSender) << "that one is over";
}

TEST(SessionTest, SourceTimeMustGrowAndAJumpStartsAnew) {
  Session session;
  (void)session.Admit(1, 0, 0, kRules);
  EXPECT_EQ(session.AdmitTime(5'000 * kMs, kRules), Time::kNext);
  EXPECT_EQ(session.elapsed_ns(), 0);
  EXPECT_EQ(session.AdmitTime(5'008 * kMs, kRules), Time::kNext);
  EXPECT_EQ(session.elapsed_ns(), 8 * kMs);
  EXPECT_EQ(session.AdmitTime(5'008 * kMs, kRules), Time::kOld);
  EXPECT_EQ(session.AdmitTime(4'008 * kMs, kRules), Time::kOld) << "exactly a second";
  EXPECT_EQ(session.AdmitTime(4'007 * kMs, kRules), Time::kJump);
  EXPECT_EQ(session.elapsed_ns(), 0);
  EXPECT_EQ(session.AdmitTime(~0ULL, kRules), Time::kJump) << "more than an hour ahead";
  EXPECT_EQ(session.AdmitTime(0, kRules), Time::kJump);
  EXPECT_EQ(session.AdmitTime(3'600'000ULL * kMs, kRules), Time::kNext);
}

TEST(ScheduleTest, LatenessIsAgainstTheShortestWayOfLate) {
  Schedule schedule;
  EXPECT_EQ(schedule.Lateness_ns(0, 50 * kMs), 0);
  EXPECT_EQ(schedule.Lateness_ns(8 * kMs, 58 * kMs), 0);
  EXPECT_EQ(schedule.Lateness_ns(16 * kMs, 166 * kMs), 100 * kMs);
  EXPECT_EQ(schedule.Lateness_ns(24 * kMs, 70 * kMs), 0) << "a shorter way sets the schedule";
  EXPECT_EQ(schedule.Lateness_ns(32 * kMs, 82 * kMs), 4 * kMs);
}

TEST(ScheduleTest, ALongerWayThatStaysBecomesTheSchedule) {
  Schedule schedule;
  std::int64_t lateness = 0;
  for (std::int64_t t = 0; t < 10'000; t += 8) {
    lateness = schedule.Lateness_ns(t * kMs, (t + (t < 1000 ? 10 : 60)) * kMs);
    if (t == 1000) {
      EXPECT_EQ(lateness, 50 * kMs);
    }
  }
  EXPECT_EQ(lateness, 0);
}

}  // namespace
}  // namespace styled::pipeline
