#include "daemon/decide/session.h"

#include <gtest/gtest.h>

#include "daemon/runtime/schedule.h"
#include "tests/support/units.h"

namespace styled::decide {
namespace {

using Arrival = Session::Arrival;
using Time = Session::Time;
using support::kMs;
const SessionRules kRules;
const source::Machine kSender{1}, kStranger{2};

TEST(SessionTest, FirstDatagramStartsASessionAndCountsNothingLost) {
  Session session;
  EXPECT_EQ(session.Admit(kSender, 1, 500, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.lost(), 0U);
}

TEST(SessionTest, SequencesDistinguishDuplicatesReorderingAndLoss) {
  Session session;
  EXPECT_EQ(session.Admit(kSender, 1, 10, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(kSender, 1, 10, 1, kRules), Arrival::kDuplicate);
  EXPECT_EQ(session.Admit(kSender, 1, 13, 2, kRules), Arrival::kNext);
  EXPECT_EQ(session.lost(), 2U);
  EXPECT_EQ(session.Admit(kSender, 1, 12, 3, kRules), Arrival::kReordered);
  EXPECT_EQ(session.Admit(kSender, 1, 12, 4, kRules), Arrival::kDuplicate);
  EXPECT_EQ(session.Admit(kSender, 1, 10, 5, kRules), Arrival::kDuplicate);
  EXPECT_EQ(session.Admit(kSender, 1, 9, 5, kRules), Arrival::kReordered);
  EXPECT_EQ(session.Admit(kSender, 1, 200, 6, kRules), Arrival::kNext);
  EXPECT_EQ(session.Admit(kSender, 1, 13, 7, kRules), Arrival::kReordered) << "too old to tell";
  EXPECT_EQ(session.Admit(kSender, 1, 0, 9, kRules), Arrival::kReordered);
}

TEST(SessionTest, ASecondSenderWaitsForTheFirstToBeSilent) {
  Session session;
  EXPECT_EQ(session.Admit(kSender, 1, 0, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(kSender, 4, 0, 99 * kMs, kRules), Arrival::kSecondSender);
  EXPECT_EQ(session.Admit(kSender, 1, 1, 99 * kMs, kRules), Arrival::kNext);
  EXPECT_EQ(session.Admit(kSender, 4, 1, 198 * kMs, kRules), Arrival::kSecondSender);
  EXPECT_EQ(session.Admit(kSender, 4, 2, 199 * kMs, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(kSender, 1, 2, 200 * kMs, kRules), Arrival::kSecondSender)
      << "roles changed";
  EXPECT_EQ(session.lost(), 0U);
}

TEST(SessionTest, TheSameSenderRestartsAtOnce) {
  Session session;
  EXPECT_EQ(session.Admit(kSender, 7, 0, 0, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(kSender, 7 + kSessionStep, 0, 1 * kMs, kRules), Arrival::kNewSession);
  EXPECT_EQ(session.Admit(kSender, 7, 1, 2 * kMs, kRules), Arrival::kSecondSender)
      << "that one is over";
}

TEST(SessionTest, ASequenceFromTheFutureChangesNothingWhileThePerformerSends) {
  Session session;
  std::int64_t now_ns = 0;
  EXPECT_EQ(session.Admit(kSender, 1, 0, now_ns, kRules), Arrival::kNewSession);
  for (std::uint64_t i = 1; i < 200; ++i) {
    now_ns += 8 * kMs;
    EXPECT_EQ(session.Admit(kSender, 1, i, now_ns, kRules), Arrival::kNext);
    EXPECT_EQ(session.Admit(kSender, 1, 1'000'000'000 + i, now_ns, kRules), Arrival::kFarAhead);
    EXPECT_EQ(session.Admit(kSender, 1, ~0ULL, now_ns, kRules), Arrival::kFarAhead);
  }
  EXPECT_EQ(session.lost(), 0U);
  EXPECT_EQ(session.last_arrival_ns(), now_ns);
}

TEST(SessionTest, AnotherCountIsAcceptedAfterASilenceAndAFewInARow) {
  for (const std::uint64_t start : {0ULL, 50ULL, 1'000'000'000ULL}) {
    Session session;
    (void)session.Admit(kSender, 1, 0, 0, kRules);
    for (std::uint64_t i = 1; i < 500; ++i) (void)session.Admit(kSender, 1, i, 0, kRules);
    // The sender continues from `start` under the same session id, 8 ms apart.
    int refused = 0;
    std::int64_t now_ns = 0;
    auto arrival = Arrival::kDuplicate;
    while (refused < 100) {
      now_ns += 8 * kMs;
      arrival =
          session.Admit(kSender, 1, start + static_cast<std::uint64_t>(refused), now_ns, kRules);
      if (arrival == Arrival::kRecounted) break;
      ++refused;
    }
    EXPECT_EQ(arrival, Arrival::kRecounted) << start;
    EXPECT_EQ(refused, 12) << "100 ms of silence, and more than a few in a row";
    EXPECT_EQ(session.Admit(kSender, 1, start + 13, now_ns + 8 * kMs, kRules), Arrival::kNext);
    EXPECT_EQ(session.lost(), 0U);
  }
}

TEST(SessionTest, ALateEchoAfterASilenceDoesNotStartANewCount) {
  Session session;
  for (std::uint64_t i = 0; i < 100; ++i) (void)session.Admit(kSender, 1, i, 0, kRules);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(session.Admit(kSender, 1, 99, 200 * kMs, kRules), Arrival::kDuplicate);
    EXPECT_EQ(session.Admit(kSender, 1, 1ULL << 60U, 200 * kMs, kRules), Arrival::kFarAhead);
  }
  EXPECT_EQ(session.Admit(kSender, 1, 100, 200 * kMs, kRules), Arrival::kNext);
}

TEST(SessionTest, LossesInASilenceAreAtMostTheFramesEverSent) {
  Session session;
  (void)session.Admit(kSender, 1, 0, 0, kRules);
  EXPECT_EQ(session.Admit(kSender, 1, 7200, 60'000 * kMs, kRules), Arrival::kNext);
  EXPECT_EQ(session.lost(), 7199U);
  EXPECT_EQ(session.Admit(kSender, 1, 7200 + 999'999'999, 120'000 * kMs, kRules),
            Arrival::kFarAhead);
  EXPECT_EQ(session.lost(), 7199U);
}

// A counter of another habit, 1000 a datagram, is accepted; what it claims to have lost is not.
TEST(SessionTest, LossIsLimitedByRateAndTime) {
  Session session;
  std::int64_t now_ns = 0;
  for (std::uint64_t i = 0; i < 600; ++i) {
    now_ns += 16 * kMs;
    EXPECT_NE(session.Admit(kSender, 1, i * 1000, now_ns, kRules), Arrival::kFarAhead);
  }
  EXPECT_LE(session.lost(), Session::kFarAhead + 4 * 600 + 100) << "of 600,000 claimed";
}

TEST(SessionTest, ASlowSenderIsNotReplacedBetweenTwoDatagrams) {
  Session session;
  std::int64_t now_ns = 0;
  for (std::uint64_t i = 0; i < 30; ++i) {
    EXPECT_NE(session.Admit(kSender, 1, i, now_ns, kRules), Arrival::kSecondSender);
    if (i > 2) {
      EXPECT_EQ(session.Admit(kStranger, 9, i, now_ns + 300 * kMs, kRules), Arrival::kSecondSender);
    }
    now_ns += 333 * kMs;
  }
  EXPECT_EQ(session.Admit(kStranger, 9, 99, now_ns + 1000 * kMs, kRules), Arrival::kNewSession);
}

TEST(SessionTest, AKnownSessionIdFromAnotherMachineIsAnotherSender) {
  Session session;
  (void)session.Admit(kSender, 1, 0, 0, kRules);
  EXPECT_EQ(session.Admit(kStranger, 1, 1, 8 * kMs, kRules), Arrival::kSecondSender);
  EXPECT_EQ(session.Admit(kStranger, 1 + kSessionStep, 0, 8 * kMs, kRules), Arrival::kSecondSender);
  EXPECT_EQ(session.Admit(kSender, 1, 1, 99 * kMs, kRules), Arrival::kNext);
  EXPECT_EQ(session.Admit(kStranger, 1, 2, 199 * kMs, kRules), Arrival::kNewSession)
      << "the first one was silent";
}

TEST(SessionTest, TimeNeverOverflows) {
  Session session;
  (void)session.Admit(kSender, 1, 0, 0, kRules);
  std::uint64_t time_ns = 0;
  int jumps = 0;
  for (int i = 0; i < 3'000'000; ++i) {
    jumps += session.AdmitTime(time_ns, kRules) == Time::kJump ? 1 : 0;
    ASSERT_GE(session.elapsed_ns(), 0);
    time_ns += 3600ULL * 1'000'000'000;
  }
  EXPECT_EQ(jumps, 2);
}

TEST(SessionTest, SourceTimeMustIncreaseAndAJumpRestartsTheSession) {
  Session session;
  (void)session.Admit(kSender, 1, 0, 0, kRules);
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

TEST(ScheduleTest, LatenessIsRelativeToTheShortestRecentDelay) {
  runtime::Schedule schedule;
  EXPECT_EQ(schedule.Lateness_ns(0, 50 * kMs), 0);
  EXPECT_EQ(schedule.Lateness_ns(8 * kMs, 58 * kMs), 0);
  EXPECT_EQ(schedule.Lateness_ns(16 * kMs, 166 * kMs), 100 * kMs);
  EXPECT_EQ(schedule.Lateness_ns(24 * kMs, 70 * kMs), 0) << "a shorter way sets the schedule";
  EXPECT_EQ(schedule.Lateness_ns(32 * kMs, 82 * kMs), 4 * kMs);
}

TEST(ScheduleTest, ALastingLongerDelayBecomesTheSchedule) {
  runtime::Schedule schedule;
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
}  // namespace styled::decide
