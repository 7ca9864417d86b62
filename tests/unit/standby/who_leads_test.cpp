// Which of two daemons leads: at the start, after silence, goodbye, restart and partition.
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
    if (const Change change = roles.OnTime(now_ns, ready, ready); change != Change::kNone)
      return change;
  }
  return Change::kNone;
}

struct RolesTest : testing::Test {
  Roles roles{5, false, kHold};
  std::int64_t now_ns = 0;
};

TEST_F(RolesTest, ADaemonThatHearsNoPeerLeadsAfterASecond) {
  EXPECT_EQ(Pass(roles, now_ns, 900), Change::kNone);
  EXPECT_EQ(roles.role(), v1::ROLE_LOOKING);
  EXPECT_EQ(Pass(roles, now_ns, 200), Change::kLead);
  EXPECT_EQ(roles.term(), 1U);
}

TEST_F(RolesTest, OneOfTwoStartingDaemonsLeads) {
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

TEST_F(RolesTest, AStandbyTakesOverAfterTheHoldAndNotBefore) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  EXPECT_EQ(Pass(roles, now_ns, 90), Change::kNone);
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 90), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 20), Change::kTakeOver);
  EXPECT_EQ(roles.term(), 4U);
  EXPECT_EQ(roles.role(), v1::ROLE_LEADING);
}

TEST_F(RolesTest, AStandbyWithoutTheStateLeadsAfterASecond) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  EXPECT_EQ(Pass(roles, now_ns, 900, false), Change::kNone) << "a busy leader is not gone";
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 900, false), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 200, false), Change::kLead);
}

TEST_F(RolesTest, AStandbyWithoutTheStateLeadsAtOnceAfterAGoodbye) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  EXPECT_EQ(roles.OnTime(now_ns, false, false), Change::kNone);
  EXPECT_EQ(roles.OnPeer({9, v1::ROLE_LEAVING, 3, false}), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 10, false), Change::kLead);
}

TEST_F(RolesTest, APauseOfThisDaemonIsNotSilenceOfThePeer) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  EXPECT_EQ(roles.OnTime(now_ns, true, true), Change::kNone);
  for (int i = 0; i < 3; ++i) {
    now_ns += 5'000 * kMs;  // stopped for five seconds
    EXPECT_EQ(roles.OnTime(now_ns, true, true), Change::kNone);
  }
  now_ns += 5'000 * kMs;
  EXPECT_EQ(roles.OnTime(now_ns, true, true), Change::kTakeOver);
}

// On a machine that pauses again and again, by a standby of another configuration: it led and gave
// way five times in 0.2 s.
TEST_F(RolesTest, ALeaderThatHadOnlyStalledIsGivenTwiceTheTimeUntilAllIsCalm) {
  const auto silent_ms = [this] {
    int ms = 10;
    while (roles.OnTime(now_ns += 10 * kMs, false, true) == Change::kNone && ms < 5'000) ms += 10;
    return ms;
  };
  EXPECT_EQ(roles.OnPeer(Leading(3, 7)), Change::kFollow);
  EXPECT_EQ(roles.OnTime(now_ns, false, true), Change::kNone);
  for (const int expected : {100, 200, 400, 800, 1000, 1000}) {
    EXPECT_EQ(silent_ms(), expected);
    EXPECT_EQ(roles.OnPeer(Leading(3, 7)), Change::kFollow) << "it was only slow";
  }
  for (int i = 0; i < 1'000; ++i) {
    EXPECT_EQ(roles.OnTime(now_ns += 10 * kMs, false, true), Change::kNone);
    EXPECT_EQ(roles.OnPeer(Leading(3, 7)), Change::kNone);
  }
  EXPECT_EQ(silent_ms(), 100);
}

TEST_F(RolesTest, AGoodbyeAndARestartNeedNoWait) {
  for (const Peer& end : {Peer{9, v1::ROLE_LEAVING, 3, false}, Peer{11, v1::ROLE_LOOKING, 0, false},
                          Peer{11, v1::ROLE_LOOKING, 0, true}}) {
    Roles standby(5, false, kHold);
    EXPECT_EQ(standby.OnPeer(Leading(9, 3)), Change::kFollow);
    EXPECT_EQ(standby.OnTime(1, true, true), Change::kNone);
    EXPECT_EQ(standby.OnPeer(end), Change::kNone);
    EXPECT_EQ(standby.OnTime(2, true, true), Change::kTakeOver);
  }
}

TEST_F(RolesTest, TheHigherTermRemainsAfterAPartition) {
  Roles a(5, false, kHold), b(9, false, kHold);
  std::int64_t a_ns = 0, b_ns = 0;
  EXPECT_EQ(Pass(a, a_ns, 1100), Change::kLead);
  EXPECT_EQ(b.OnPeer(Leading(5, a.term())), Change::kFollow);
  EXPECT_EQ(Pass(b, b_ns, 200), Change::kTakeOver);  // the wire is cut
  EXPECT_EQ(b.OnPeer(Leading(5, a.term())), Change::kNone);
  EXPECT_EQ(a.OnPeer(Leading(9, b.term())), Change::kFollow);
  EXPECT_EQ(a.term(), b.term());
}

TEST_F(RolesTest, TheSmallerNumberRemainsOfTwoThatStartedSeparately) {
  Roles a(5, false, kHold), b(9, false, kHold);
  std::int64_t a_ns = 0, b_ns = 0;
  EXPECT_EQ(Pass(a, a_ns, 1100), Change::kLead);
  EXPECT_EQ(Pass(b, b_ns, 1100), Change::kLead);
  EXPECT_EQ(a.OnPeer(Leading(9, b.term())), Change::kNone);
  EXPECT_EQ(b.OnPeer(Leading(5, a.term())), Change::kFollow);
}

TEST_F(RolesTest, ARequestForTheLeadIsAnnouncedAndWaitsForTheGoodbye) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  roles.RequestLead();
  EXPECT_EQ(roles.advertised_role(), v1::ROLE_LEADING);
  EXPECT_EQ(roles.advertised_term(), 4U);
  EXPECT_EQ(roles.role(), v1::ROLE_FOLLOWING);
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kNone) << "its journal goes on until it has heard";
  EXPECT_EQ(roles.OnTime(1, true, true), Change::kNone);
  EXPECT_EQ(roles.OnPeer({9, v1::ROLE_LEAVING, 4, false}), Change::kNone);
  EXPECT_EQ(roles.OnTime(2, true, true), Change::kTakeOver);
  EXPECT_EQ(roles.term(), 4U);
  EXPECT_EQ(roles.OnPeer({9, v1::ROLE_FOLLOWING, 4, false}), Change::kNone);
}

TEST_F(RolesTest, ARequestThatTheLeaderDoesNotReceiveBecomesATakeoverAfterTheHold) {
  EXPECT_EQ(roles.OnPeer(Leading(9, 3)), Change::kFollow);
  roles.RequestLead();
  EXPECT_EQ(Pass(roles, now_ns, 200), Change::kTakeOver);
  EXPECT_EQ(roles.term(), 4U);
}

// A daemon that was started behind a network that was not up yet must not end a running show.
TEST_F(RolesTest, TheLongerShowRemainsOfTwoLeadersThatNeverMet) {
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

// A term that no pair reaches is ignored: the next one would wrap around to 0.
TEST_F(RolesTest, ATermThatNoPairReachesIsIgnored) {
  EXPECT_EQ(roles.OnPeer(Leading(9, ~std::uint64_t{0})), Change::kNone);
  EXPECT_EQ(Pass(roles, now_ns, 1100), Change::kLead);
  for (const std::uint64_t term :
       {~std::uint64_t{0}, std::uint64_t{1} << 63U, (std::uint64_t{1} << 32U) + 1}) {
    EXPECT_EQ(roles.OnPeer(Leading(9, term)), Change::kNone);
    EXPECT_EQ(roles.role(), v1::ROLE_LEADING);
    EXPECT_EQ(roles.term(), 1U);
  }
}

TEST_F(RolesTest, TheHighestTermDoesNotWrapAround) {
  EXPECT_EQ(roles.OnPeer(Leading(9, Roles::kMostTerm)), Change::kFollow);
  roles.RequestLead();
  EXPECT_EQ(roles.advertised_term(), Roles::kMostTerm);
  EXPECT_EQ(Pass(roles, now_ns, 200), Change::kTakeOver);
  EXPECT_EQ(roles.term(), Roles::kMostTerm);
  Pass(roles, now_ns, 70'000);
  EXPECT_EQ(roles.term(), Roles::kMostTerm);
}

// The program at the peer's address is a daemon of another pair.
TEST_F(RolesTest, ALeaderThatHearsAThirdDaemonDoesNotTakeTheLead) {
  Peer stranger = Leading(3, 9);
  stranger.hears = 77;
  EXPECT_EQ(Pass(roles, now_ns, 1100), Change::kLead);
  EXPECT_EQ(roles.OnPeer(stranger), Change::kNone);
  EXPECT_EQ(roles.term(), 1U);
  stranger.hears = 5;  // this one: it is the peer after all
  EXPECT_EQ(roles.OnPeer(stranger), Change::kFollow);
}

TEST_F(RolesTest, AStartingDaemonDoesNotFollowALeaderThatHearsAThirdOne) {
  Peer stranger = Leading(3, 9);
  stranger.hears = 77;
  Change change = Change::kNone;
  for (int i = 0; i < 300 && change == Change::kNone; ++i) {
    EXPECT_EQ(roles.OnPeer(stranger), Change::kNone);
    change = Pass(roles, now_ns, 10);
  }
  EXPECT_EQ(change, Change::kLead);
  EXPECT_EQ(roles.term(), 1U) << "the stranger's term does not count";
  EXPECT_LE(now_ns, 2600 * kMs);
}

// The leader still has its last start in its ears.
TEST_F(RolesTest, ARestartedDaemonFollowsOnceItIsHeard) {
  Peer leader = Leading(3, 9);
  leader.hears = 4;
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(roles.OnPeer(leader), Change::kNone);
    EXPECT_EQ(Pass(roles, now_ns, 10), Change::kNone);
  }
  leader.hears = 0;
  EXPECT_EQ(roles.OnPeer(leader), Change::kFollow);
}

// With another hold_ms, the leader's signs of life come as rarely as its own allows.
TEST_F(RolesTest, AStandbyWaitsForTheLeadersHoldUpToHalfASecond) {
  for (const auto& [hold_ms, waits_ms] : {std::pair{20, 100}, {300, 300}, {5000, 500}}) {
    Roles standby(5, false, kHold);
    std::int64_t standby_ns = 0;
    standby.SetHoldOfPeer(hold_ms * kMs);
    EXPECT_EQ(standby.OnPeer(Leading(9, 3)), Change::kFollow);
    EXPECT_EQ(Pass(standby, standby_ns, waits_ms - 10), Change::kNone) << hold_ms;
    EXPECT_EQ(Pass(standby, standby_ns, 30), Change::kTakeOver) << hold_ms;
  }
}

}  // namespace
}  // namespace styled::standby
