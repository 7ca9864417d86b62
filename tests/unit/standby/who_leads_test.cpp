// Who of two daemons leads: at the start, after silence, goodbye, restart and partition.
#include <gtest/gtest.h>

#include "daemon/standby/roles.h"

namespace styled::standby {
namespace {

using Change = Roles::Change;
constexpr std::int64_t kMs = 1'000'000, kHold = 100 * kMs;

Peer Leading(std::uint64_t daemon, std::uint64_t term) {
  return {daemon, v1::ROLE_LEADING, term, false};
}

// Passes time in steps of 10 ms; the first change, or none.
Change Pass(Roles& roles, std::int64_t& now_ns, int ms, bool ready = true) {
  for (int i = 0; i < ms; i += 10) {
    now_ns += 10 * kMs;
    if (const Change change = roles.OnTime(now_ns, ready); change != Change::kNone) return change;
  }
  return Change::kNone;
}

struct RolesTest : testing::Test {
  Roles roles{5, false, kHold};
  std::int64_t now_ns = 0;
};

TEST_F(RolesTest, ADaemonThatHearsNobodyLeadsAfterASecond) {
  EXPECT_EQ(Pass(roles, now_ns, 900), Change::kNone);
  EXPECT_EQ(roles.role(), v1::ROLE_LOOKING);
  EXPECT_EQ(Pass(roles, now_ns, 200), Change::kLead);
  EXPECT_EQ(roles.term(), 1U);
}

TEST_F(RolesTest, OfTwoThatHaveJustStartedOneLeads) {
  for (const bool first : {false, true}) {
    for (const bool other_first : {false, true}) {
      Roles one(5, first, kHold), other(9, other_first, kHold);
      const Change a = one.OnPeer({9, v1::ROLE_LOOKING, 0, other_first});
      const Change b = other.OnPeer({5, v1::ROLE_LOOKING, 0, first});
      EXPECT_NE(a == Change::kLead, b == Change::kLead) << first << other_first;
      if (first != other_first) EXPECT_EQ(a == Change::kLead, first);
    }
  }
}

TEST_F(RolesTest, AStandbyGoesOnAfterTheHoldAndNotBefore) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  EXPECT_EQ(Pass(roles, now_ns, 90), Change::kNone);
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 90), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 20), Change::kTakeOver);
  EXPECT_EQ(roles.term(), 4U);
  EXPECT_EQ(roles.role(), v1::ROLE_LEADING);
}

TEST_F(RolesTest, WithoutTheStateItLeadsAllTheSame) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  EXPECT_EQ(Pass(roles, now_ns, 200, false), Change::kLead);
}

TEST_F(RolesTest, ItsOwnPauseIsNotTheOthersSilence) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  EXPECT_EQ(roles.OnTime(now_ns, true), Change::kNone);
  for (int i = 0; i < 3; ++i) {
    now_ns += 5'000 * kMs;  // stopped for five seconds
    EXPECT_EQ(roles.OnTime(now_ns, true), Change::kNone);
  }
  now_ns += 5'000 * kMs;
  EXPECT_EQ(roles.OnTime(now_ns, true), Change::kTakeOver);
}

TEST_F(RolesTest, AGoodbyeAndARestartNeedNoWait) {
  for (const Peer& end : {Peer{9, v1::ROLE_LEAVING, 3, false}, Peer{11, v1::ROLE_LOOKING, 0, false},
                          Peer{11, v1::ROLE_LOOKING, 0, true}}) {
    Roles standby(5, false, kHold);
    EXPECT_EQ(standby.OnPeer(Leading(9, 3)), Change::kFollow);
    EXPECT_EQ(standby.OnTime(1, true), Change::kNone);
    EXPECT_EQ(standby.OnPeer(end), Change::kNone);
    EXPECT_EQ(standby.OnTime(2, true), Change::kTakeOver);
  }
}

TEST_F(RolesTest, AfterAPartitionTheHigherTermStays) {
  Roles a(5, false, kHold), b(9, false, kHold);
  std::int64_t a_ns = 0, b_ns = 0;
  EXPECT_EQ(Pass(a, a_ns, 1100), Change::kLead);
  EXPECT_EQ(b.OnPeer(Leading(5, a.term())), Change::kFollow);
  EXPECT_EQ(Pass(b, b_ns, 200), Change::kTakeOver);  // the wire is cut
  EXPECT_EQ(b.OnPeer(Leading(5, a.term())), Change::kNone);
  EXPECT_EQ(a.OnPeer(Leading(9, b.term())), Change::kFollow);
  EXPECT_EQ(a.term(), b.term());
}

TEST_F(RolesTest, OfTwoThatStartedApartTheSmallerNumberStays) {
  Roles a(5, false, kHold), b(9, false, kHold);
  std::int64_t a_ns = 0, b_ns = 0;
  EXPECT_EQ(Pass(a, a_ns, 1100), Change::kLead);
  EXPECT_EQ(Pass(b, b_ns, 1100), Change::kLead);
  EXPECT_EQ(a.OnPeer(Leading(9, b.term())), Change::kNone);
  EXPECT_EQ(b.OnPeer(Leading(5, a.term())), Change::kFollow);
}

TEST_F(RolesTest, AWishIsSaidAndWaitsForTheGoodbye) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  roles.OnWish();
  EXPECT_EQ(roles.said_role(), v1::ROLE_LEADING);
  EXPECT_EQ(roles.said_term(), 4U);
  EXPECT_EQ(roles.role(), v1::ROLE_FOLLOWING);
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kNone) << "its journal goes on until it has heard";
  EXPECT_EQ(roles.OnTime(1, true), Change::kNone);
  EXPECT_EQ(roles.OnPeer({9, v1::ROLE_LEAVING, 4, false}), Change::kNone);
  EXPECT_EQ(roles.OnTime(2, true), Change::kTakeOver);
  EXPECT_EQ(roles.term(), 4U);
  EXPECT_EQ(roles.OnPeer({9, v1::ROLE_FOLLOWING, 4, false}), Change::kNone);
}

TEST_F(RolesTest, AWishOfWhichTheLeaderHearsNothingIsATakeoverAfterTheHold) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  roles.OnWish();
  EXPECT_EQ(Pass(roles, now_ns, 200), Change::kTakeOver);
  EXPECT_EQ(roles.term(), 4U);
}

// A daemon that was started behind a network that was not up yet must not end a running show.
TEST_F(RolesTest, OfTwoThatNeverHeardOfEachOtherTheLongerShowStays) {
  Roles show(9, false, kHold), fresh(5, true, kHold);
  std::int64_t show_ns = 0, fresh_ns = 0;
  EXPECT_EQ(Pass(show, show_ns, 1100), Change::kLead);
  Pass(show, show_ns, 70'000);
  EXPECT_EQ(Pass(fresh, fresh_ns, 1100), Change::kLead);
  Pass(fresh, fresh_ns, 10'000);
  EXPECT_GT(show.term(), fresh.term());
  EXPECT_EQ(show.OnPeer(Leading(5, fresh.term())), Change::kNone);
  EXPECT_EQ(fresh.OnPeer(Leading(9, show.term())), Change::kFollow);
}

}  // namespace
}  // namespace styled::standby
