// Two pipelines, of which one follows the other: same poses bit for bit, and nothing is lost when
// the leader ends.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "tests/unit/standby/pair_test.h"

namespace styled::support {
namespace {

class FollowingTest : public PairTest {
 protected:
  std::string last_;  // entry of the journal
};

TEST_F(FollowingTest, TheStandbyStylesEveryFrameAsTheLeaderDoesAndPublishesNone) {
  StartB();
  Begin();
  Frames(60);
  Wear(*a_, "style2", 300);
  Frames(60);
  const v1::StandbyState state = b_->State();
  EXPECT_EQ(state.role(), "following");
  EXPECT_TRUE(state.ready()) << state.why_not();
  EXPECT_EQ(state.compared(), 120U);
  EXPECT_EQ(state.different(), 0U);
  EXPECT_TRUE(b_->publisher.frames.empty());
  EXPECT_EQ(a_->publisher.frames.size(), 120U);
}

// Without the comparison of poses, a standby that styles nothing would pass.
TEST_F(FollowingTest, ADifferentStateIsCounted) {
  auto other = std::make_shared<pipeline::RuntimeConfig>(*config_);
  other->network = erd::RandomStylizer(5, 4);
  StartB();
  Begin();
  Frames(10);
  Wear(*a_, "style2", 0);
  Frames(10);
  EXPECT_EQ(b_->State().different(), 0U);
  (void)b_->mailboxes.reloads.Push({other, nullptr});
  Frames(20);
  EXPECT_GT(b_->State().different(), 10U);
}

TEST_F(FollowingTest, AStandbyThatStartsLateHasTheCheckpointAndStylesTheSame) {
  Begin();
  Frames(50);
  Wear(*a_, "style3", 1000);
  Frames(20);  // the fade is under way
  StartB();
  Frames(100);
  const v1::StandbyState state = b_->State();
  EXPECT_TRUE(state.ready()) << state.why_not();
  EXPECT_EQ(state.compared(), 100U);
  EXPECT_EQ(state.different(), 0U);
}

TEST_F(FollowingTest, AKilledLeaderLosesNoFrameAndChangesNone) {
  Alone witness(*this);
  Node& alone = witness.node;
  const auto send = [&](const Bytes& datagram) { witness.Send(datagram); };
  StartB();
  send(rig_.Body());
  Wear(*a_, "style1", 0);
  Wear(alone, "style1", 0);
  for (int i = 0; i < 100; ++i) send(rig_.Frame());
  auto left_behind = std::move(a_->publisher.frames);
  a_.reset();  // kill -9
  for (int i = 0; i < 100; ++i) send(rig_.Frame());
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(b_->State().takeovers(), 1U);
  std::map<std::uint64_t, v1::Frame> seen;
  for (const auto& frame : left_behind) seen.emplace(frame.sequence(), frame);
  for (const auto& frame : b_->publisher.frames) seen.emplace(frame.sequence(), frame);
  ASSERT_EQ(alone.publisher.frames.size(), 200U);
  ASSERT_EQ(seen.size(), 200U);
  for (const v1::Frame& whole : alone.publisher.frames) {
    const v1::Frame& frame = seen.at(whole.sequence());
    EXPECT_EQ(frame.epoch(), 5U);
    EXPECT_EQ(frame.source_time_ns(), whole.source_time_ns());
    ASSERT_EQ(frame.rotations_size(), whole.rotations_size());
    for (int i = 0; i < whole.rotations_size(); ++i) {
      ASSERT_EQ(frame.rotations(i), whole.rotations(i)) << whole.sequence();
    }
    EXPECT_EQ(frame.styles_size(), whole.styles_size());
  }
}

// The leader's last messages may have been lost in its queues.
TEST_F(FollowingTest, TheLastFramesOfTheLeaderAreSentAgain) {
  StartB();
  Begin();
  Frames(50);
  a_.reset();
  Turn(500);
  ASSERT_FALSE(b_->publisher.frames.empty());
  EXPECT_LT(b_->publisher.frames.front().sequence(), 45U);
  EXPECT_EQ(b_->publisher.frames.back().sequence(), 51U);
  EXPECT_EQ(b_->publisher.frames.back().flags() & v1::FLAG_STALE, v1::FLAG_STALE);
}

TEST_F(FollowingTest, FramesThatOnlyTheStandbyReceivedAreStyledAfterATakeover) {
  StartB();
  Begin();
  Frames(50);
  a_.reset();
  for (int i = 0; i < 6; ++i) Send(rig_.Frame());
  Turn(200);
  std::set<std::uint64_t> sequences;
  for (const auto& frame : b_->publisher.frames) sequences.insert(frame.sequence());
  for (std::uint64_t i = 51; i <= 56; ++i) EXPECT_TRUE(sequences.contains(i)) << i;
}

TEST_F(FollowingTest, AStandbyWithoutInputFollowsAndNamesTheMissingPerformers) {
  StartB();
  Send(rig_.Body(), true, false);
  for (int i = 0; i < 60; ++i) {
    Send(rig_.Frame(), true, false);
    Turn(8);
  }
  const v1::StandbyState state = b_->State();
  EXPECT_EQ(state.different(), 0U);
  EXPECT_EQ(state.compared(), 60U);
  ASSERT_EQ(state.without_input_size(), 1);
  EXPECT_EQ(state.without_input(0), "rig.a");
}

TEST_F(FollowingTest, FramesThatDidNotReachTheStandbyAreInTheJournal) {
  StartB();
  Begin();
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    Send(rig_.Frame(), true, random() % 4 != 0);
    Turn(8);
  }
  EXPECT_EQ(b_->State().compared(), 100U);
  EXPECT_EQ(b_->State().different(), 0U);
}

TEST_F(FollowingTest, AfterLostEntriesTheStateIsFetchedAgain) {
  StartB();
  Begin();
  Frames(30);
  const auto fetched = b_->State().fetched();
  wire_.lose = 7;
  Frames(60);
  EXPECT_GT(b_->State().fetched(), fetched);
  EXPECT_TRUE(b_->State().ready());
  const auto different = b_->State().different();
  Frames(60);
  EXPECT_EQ(b_->State().different(), different);
}

TEST_F(FollowingTest, AStandbyRefusesChangesAndAnswersQueries) {
  StartB();
  Begin();
  Frames(10);
  v1::Request set;
  set.set_performer("rig.a");
  set.mutable_set()->set_strength(0.5F);
  const v1::Reply reply = b_->Ask(set);
  EXPECT_EQ(reply.code(), v1::CODE_STANDBY);
  EXPECT_NE(reply.reason().find("the other"), std::string::npos) << reply.reason();
  v1::Request list;
  list.mutable_list();
  EXPECT_EQ(b_->Ask(list).code(), v1::CODE_OK);
  v1::Request take;
  take.set_performer("rig.a");
  take.mutable_take_checkpoint();
  EXPECT_EQ(b_->Ask(take).code(), v1::CODE_OK);
}

TEST_F(FollowingTest, LeadTransfersTheLeadWithoutAGap) {
  StartB();
  Begin();
  Wear(*a_, "style1", 0);
  Frames(50);
  v1::Request lead;
  lead.mutable_lead();
  ASSERT_EQ(b_->Ask(lead).code(), v1::CODE_OK);
  Frames(50);
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(a_->State().role(), "following");
  EXPECT_TRUE(a_->State().ready()) << a_->State().why_not();
  EXPECT_EQ(a_->State().different(), 0U);
  EXPECT_EQ(Seen().size(), 100U);
  ASSERT_EQ(a_->Ask(lead).code(), v1::CODE_OK);  // and back
  Frames(50);
  EXPECT_EQ(a_->State().role(), "leading");
  EXPECT_EQ(Seen().size(), 150U);
  EXPECT_EQ(a_->State().term(), 3U);
  EXPECT_EQ(a_->publisher.frames.back().epoch(), 5U);
}

TEST_F(FollowingTest, ALeaderThatWasInterruptedYieldsAndFollows) {
  StartB();
  Begin();
  Frames(50);
  auto stopped = std::move(a_);
  Frames(50);  // the standby has taken over
  EXPECT_EQ(b_->State().role(), "leading");
  a_ = std::move(stopped);
  a_->clock.now_ns += 400'000'000;
  Frames(50);
  EXPECT_EQ(a_->State().role(), "following");
  EXPECT_EQ(a_->State().different(), 0U);
  EXPECT_EQ(Seen().size(), 150U);
}

TEST_F(FollowingTest, ARestartedLeaderBecomesTheStandby) {
  StartB();
  Begin();
  Frames(50);
  a_.reset();
  wire_.to_a.clear();
  Turn(20);  // faster than the hold
  a_ = std::make_unique<Node>(wire_, true, 6, 3'000'000'000, config_, kTopics);
  wire_.b_asked = true;
  Turn(5);
  Frames(50);
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(a_->State().role(), "following");
  EXPECT_TRUE(a_->State().ready());
  EXPECT_EQ(a_->State().different(), 0U);
}

TEST_F(FollowingTest, APartitionHealsAndOneLeads) {
  StartB();
  Begin();
  Frames(50);
  wire_.cut = true;
  Frames(50);
  EXPECT_EQ(a_->State().role(), "leading");
  EXPECT_EQ(b_->State().role(), "leading");
  wire_.cut = false;
  Frames(50);
  EXPECT_NE(a_->State().role(), b_->State().role());
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(Seen().size(), 150U);
}

TEST_F(FollowingTest, ASilentPerformerIsStaleAndForgottenAtBothDaemons) {
  StartB();
  Begin();
  Frames(20);
  Turn(400);
  EXPECT_EQ(a_->publisher.frames.back().flags() & v1::FLAG_STALE, v1::FLAG_STALE);
  Frames(20);
  EXPECT_EQ(b_->State().compared(), 40U);
  EXPECT_EQ(b_->State().different(), 0U);
  const auto fetched = b_->State().fetched();
  for (int i = 0; i < 700; ++i) {
    a_->clock.now_ns += 100'000'000;
    b_->clock.now_ns += 100'000'000;
    Turn(1);
  }
  EXPECT_EQ(b_->State().fetched(), fetched);
  v1::Request status;
  status.mutable_status();
  EXPECT_EQ(b_->Ask(status).status().stats().performers_size(),
            a_->Ask(status).status().stats().performers_size());
}

// Of performers who are away the standby knows the numbers, too: subscribers drop old ones.
TEST_F(FollowingTest, AReturningPerformerContinuesWithLaterNumbersAfterATakeover) {
  Begin();
  Wear(*a_, "style1", 0);
  Frames(90);
  for (int i = 0; i < 700; ++i) {  // longer than the leader keeps silent performers
    a_->clock.now_ns += 100'000'000;
    Turn(1);
  }
  StartB();
  ASSERT_TRUE(b_->State().ready()) << b_->State().why_not();
  a_.reset();
  Turn(300);
  ASSERT_EQ(b_->State().role(), "leading");
  Send(rig_.Body());
  Frames(3);
  ASSERT_FALSE(b_->publisher.frames.empty());
  EXPECT_GT(b_->publisher.frames.front().sequence(), 90U);
  EXPECT_EQ(b_->publisher.frames.front().epoch(), 5U);
  EXPECT_EQ(b_->publisher.frames.front().styles(0).style(), "style1");
}

TEST_F(FollowingTest, APerformerWhoHasLeftDoesNotReturnWithATakeover) {
  StartB();
  Begin();
  Frames(20);
  for (int i = 0; i < 700; ++i) {
    a_->clock.now_ns += 100'000'000;
    b_->clock.now_ns += 100'000'000;
    Turn(1);
  }
  a_.reset();
  Turn(300);
  ASSERT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(b_->counters.Get(runtime::Counter::kPipelinePerformers), 0U);
}

// Orders that the old leader has acknowledged are in its journal, and come first.
TEST_F(FollowingTest, LeadTakesOverAfterTheLastRequestOfTheOldLeader) {
  StartB();
  Begin();
  Frames(20);
  Wear(*a_, "style4", 0);
  auto on_the_way = std::exchange(wire_.to_b, {});
  v1::Request lead;
  lead.mutable_lead();
  ASSERT_EQ(b_->Ask(lead).code(), v1::CODE_OK);
  wire_.to_b = std::move(on_the_way);
  Frames(20);
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(a_->State().role(), "following");
  EXPECT_EQ(b_->publisher.frames.back().styles(0).style(), "style4");
  EXPECT_EQ(Seen().size(), 40U);
}

// The leader's data must pass the same checks as a rig's, and cannot end this daemon.
TEST_F(FollowingTest, AnInvalidJournalHasNoEffect) {
  StartB();
  Begin();
  Frames(20);
  const auto say = [&](const std::function<void(v1::Journal&)>& change) {
    v1::Journal entry;
    entry.ParseFromString(last_);
    change(entry);
    wire_.to_b.push_back(entry.SerializeAsString());
    Turn(1);
  };
  wire_.spy = [this](const std::string& message) {
    v1::Journal entry;
    if (entry.ParseFromString(message) && entry.has_batch()) last_ = message;
  };
  Frames(3);
  wire_.spy = nullptr;
  ASSERT_FALSE(last_.empty());
  for (const std::int64_t time_ns :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()}) {
    say([&](v1::Journal& e) {
      e.set_now_ns(time_ns);
      e.set_wall_ns(time_ns);
    });
  }
  say([](v1::Journal& e) { e.mutable_batch()->set_source(4'000'000'000U); });
  say([](v1::Journal& e) { e.mutable_batch()->mutable_frames(0)->set_machine("x"); });
  say([](v1::Journal& e) { e.mutable_batch()->mutable_frames(0)->set_rotations("short"); });
  say([](v1::Journal& e) { e.mutable_batch()->mutable_frames(0)->set_published(~0ULL); });
  say([](v1::Journal& e) { e.mutable_batch()->mutable_frames(0)->set_performer("../nobody"); });
  say([](v1::Journal& e) {
    const v1::Handled one = e.batch().frames(0);
    for (int i = 0; i < 1000; ++i) *e.mutable_batch()->add_frames() = one;
  });
  say([](v1::Journal& e) {
    std::string rotations = e.batch().frames(0).rotations();
    for (std::size_t i = 0; i + 4 <= rotations.size(); i += 4) {
      const float huge = 1e30F;
      std::memcpy(rotations.data() + i, &huge, sizeof huge);
    }
    e.mutable_batch()->mutable_frames(0)->set_rotations(rotations);
  });
  say([](v1::Journal& e) { e.mutable_checkpoint()->set_version(77); });
  say([](v1::Journal& e) { e.mutable_beginning()->set_changed(true); });
  say([](v1::Journal& e) { e.mutable_settings()->set_text("[[[ no table"); });
  say([](v1::Journal& e) { e.mutable_style()->set_file("no style"); });
  say([](v1::Journal& e) { e.set_too_large(std::string(1000, '\n')); });
  say([](v1::Journal& e) { e.mutable_silence()->add_stale()->set_performer("rig.nobody"); });
  say([](v1::Journal& e) { e.mutable_request()->mutable_set()->set_strength(1e30F); });
  say([](v1::Journal& e) { e.set_version(1); });
  say([](v1::Journal& e) { e.set_daemon(9); });
  wire_.to_b.emplace_back("no message at all");
  Turn(10);
  Frames(300);  // it requests the whole state again
  for (int i = 0; i < 11; ++i) {
    for (int k = 0; k < 100; ++k) Turn(10);
  }
  Frames(100);
  const v1::StandbyState state = b_->State();
  EXPECT_EQ(state.role(), "following");
  EXPECT_TRUE(state.ready()) << state.why_not();
  const auto different = state.different();
  Frames(100);
  EXPECT_EQ(b_->State().different(), different);
}

// A rig whose protocol has no numbers: each daemon counts on its own.
TEST_F(FollowingTest, ARigNumberedByEachDaemonContinuesWithoutALossOrANewSession) {
  StartB();
  Rig other("a", 1234);
  other.sequence = 40'000;
  other.time_ns = 900'000'000'000;
  Send(rig_.Body(), true, false);
  Send(other.Body(), false, true);
  Turn(1);
  const auto both = [&] {
    const v1::SourceFrame pose = rig_.MakeFrame();
    Send(rig_.Frame(), true, false);
    Send(other.Frame([&](v1::SourceFrame& frame) {
      *frame.mutable_rotations() = pose.rotations();
      *frame.mutable_root_position() = pose.root_position();
    }),
         false, true);
    Turn(8);
  };
  for (int i = 0; i < 60; ++i) both();
  a_.reset();
  for (int i = 0; i < 60; ++i) both();
  EXPECT_EQ(b_->counters.Get(runtime::Counter::kPipelineSessions), 1U);
  EXPECT_EQ(b_->counters.Get(runtime::Counter::kPipelineSecondSender), 0U);
  EXPECT_EQ(b_->counters.Get(runtime::Counter::kPipelineFrames), 120U);
}

}  // namespace
}  // namespace styled::support
