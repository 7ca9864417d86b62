// How a standby gets the leader's state, and when it says that it is not the leader's: size and
// pace of the state, settings that differ, poses that differ.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>

#include "daemon/styles/style_file.h"
#include "daemon/styles/style_list.h"
#include "daemon/styles/style_requests.h"
#include "model/net/load.h"
#include "tests/unit/net/stgcn_causal/random_weights.h"
#include "tests/unit/standby/pair_test.h"

namespace styled::support {
namespace {

class StateTest : public PairTest {
 protected:
  // Weights whose styles can be made, with `count` made styles of `bytes` each.
  static std::shared_ptr<pipeline::RuntimeConfig> WithStyles(int count, std::size_t bytes) {
    auto config = MakeConfig();
    auto network = net::Parse(stgcn_causal::RandomWeights(5, 16, 3).Bytes(), "random");
    EXPECT_TRUE(network.ok());
    config->network = std::move(network.value());
    config->loaded = config->network;
    config->own_styles = static_cast<int>(config->network->model().styles.size());
    config->weights_hash = "crc32c:00001234";
    for (int i = 0; i < count; ++i) {
      pipeline::MadeStyle style;
      style.name = "made" + std::to_string(i);
      style.code = config->network->space()->MakeCode({.sources = {{.style = 1 + i % 4}}});
      style.source = std::string(bytes, 'x');
      EXPECT_TRUE(pipeline::PutStyle(std::move(style), *config).ok());
    }
    return config;
  }
  // The two as a and b, of which b perhaps lacks styles.
  void Begin(std::shared_ptr<pipeline::RuntimeConfig> leaders,
             std::shared_ptr<const pipeline::RuntimeConfig> standbys) {
    config_ = leaders;
    a_ = std::make_unique<Node>(wire_, true, 5, 1'000'000'000'000, leaders, kTopics);
    Turn(1200);
    files_a_.running = leaders;
    files_b_.running = standbys;
    StartB(standbys);
  }
  // A node's files thread; a slow one takes several turns for a style.
  struct Files {
    std::shared_ptr<const pipeline::RuntimeConfig> running;
    pipeline::StyleRequests requests{};
    int turns = 0;
    std::unique_ptr<pipeline::Exchange> busy{};
    int left = 0;

    void Turn(Node& node) {
      for (int done = 0; done < 2000; ++done) {
        if (busy == nullptr && !node.mailboxes.takes.Pop(busy)) return;
        if (left == 0) left = turns + 1;
        if (--left > 0) return;
        auto made = requests.Do(*running, *busy);
        if (made != nullptr) running = made;
        ASSERT_TRUE(node.mailboxes.reloads.Push({std::move(made), std::move(busy)}));
        node.Work();
      }
    }
  };
  void SuperviseB(int ms) {
    for (int i = 0; i < ms; ++i) {
      files_b_.Turn(*b_);
      Turn(1);
    }
  }
  // Frames of the rig at both, the files threads of both beside them.
  void FramesAndFiles(int count) {
    for (int i = 0; i < count; ++i) {
      Send(rig_.Frame());
      for (int ms = 0; ms < 8; ++ms) {
        if (a_ != nullptr) files_a_.Turn(*a_);
        if (b_ != nullptr) files_b_.Turn(*b_);
        Turn(1);
      }
    }
  }
  // A Like of a variation, as an operator gives it to a.
  void Like(const std::string& name, int seed, const std::string& performer,
            float transition_ms = 100) {
    auto exchange = std::make_unique<pipeline::Exchange>();
    exchange->request.set_performer(performer);
    auto& like = *exchange->request.mutable_like();
    like.set_name(name);
    like.set_transition_ms(transition_ms);
    const auto& styles = files_a_.running->network->model().styles;
    like.mutable_vary()->set_style(styles[static_cast<std::size_t>(1 + seed % 4)].name);
    like.mutable_vary()->set_seed(static_cast<std::uint64_t>(seed));
    ASSERT_TRUE(a_->mailboxes.commands.Push(std::move(exchange)));
  }
  // A request for a's files thread.
  void AskFiles(const v1::Request& request) {
    auto exchange = std::make_unique<pipeline::Exchange>();
    exchange->request = request;
    ASSERT_TRUE(a_->mailboxes.takes.Push(std::move(exchange)));
  }
  // Entries of a kind that a has sent to b from now on.
  void Count(v1::Journal::WhatCase kind) {
    counted_ = 0;
    wire_.spy = [this, kind](const std::string& message) {
      v1::Journal entry;
      largest_ = std::max(largest_, message.size());
      if (entry.ParseFromString(message) && entry.what_case() == kind) ++counted_;
    };
  }
  // All files of the made styles.
  static std::size_t BytesOf(const pipeline::RuntimeConfig& config) {
    std::size_t bytes = 0;
    for (const auto& [name, style] : config.made) {
      bytes += pipeline::FormatStyleFile(*style, config).size();
    }
    return bytes;
  }
  // One leads and one follows.
  void ExpectOneLeads() {
    EXPECT_EQ(a_->State().role(), "leading");
    EXPECT_EQ(b_->State().role(), "following");
  }

  Files files_a_, files_b_;
  int counted_ = 0;
  std::size_t largest_ = 0;
};

// The reader would cut the wire at a larger message, and both would lead for good.
TEST_F(StateTest, EachStyleIsAMessage) {
  wire_.max_bytes = 20'000;
  Count(v1::Journal::kStyle);
  Begin(WithStyles(60, 200), WithStyles(0, 0));
  SuperviseB(3000);
  ExpectOneLeads();
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
  EXPECT_EQ(files_b_.running->made.size(), 60U);
  EXPECT_EQ(files_b_.running->network->model().styles.size(),
            config_->network->model().styles.size());
  EXPECT_GE(counted_, 60);
  EXPECT_LE(b_->State().fetched(), 3U) << "all are imported, and then the state is fetched once";
  EXPECT_LT(largest_, 20'000U);
  EXPECT_GT(BytesOf(*config_), 40'000U) << "the control: together they would not fit";
}

// Made, shown, replaced while it is shown, renamed and removed: the standby changes at the leader's
// frame, though its files thread needs longer, and is ready all the time.
TEST_F(StateTest, FrequentStyleChangesTakeEffectAtTheLeadersFrame) {
  Begin(WithStyles(2, 10), WithStyles(2, 10));
  SuperviseB(200);
  Send(rig_.Body());
  FramesAndFiles(20);
  ASSERT_TRUE(b_->State().ready()) << b_->State().why_not();
  const auto before = b_->State();
  files_b_.turns = 21;  // ms
  for (int i = 0; i < 60; ++i) {
    Like("s" + std::to_string(i % 3), i, i % 4 == 0 ? "" : "rig.a");
    if (i % 3 == 2) Like("s" + std::to_string((i + 1) % 3), i + 1, "rig.a");
    v1::Request request;
    if (i % 10 == 7) {
      request.mutable_rename_style()->set_name("s0");
      request.mutable_rename_style()->set_to("other");
      AskFiles(request);
    } else if (i % 10 == 9) {
      request.mutable_remove_style()->set_name("other");
      AskFiles(request);
    }
    FramesAndFiles(8);
    EXPECT_TRUE(b_->State().ready()) << i << ": " << b_->State().why_not();
  }
  FramesAndFiles(20);
  const auto after = b_->State();
  EXPECT_GT(after.compared() - before.compared(), 400U);
  EXPECT_EQ(after.different() - before.different(), 0U);
  EXPECT_EQ(after.fetched(), before.fetched());
  EXPECT_EQ(files_b_.running->made.size(), files_a_.running->made.size());
  EXPECT_TRUE(pipeline::PlacesOf(*files_b_.running).entries ==
              pipeline::PlacesOf(*files_a_.running).entries);
}

// The files thread of the standby hangs: the frames go on there, and it says why it is not ready.
TEST_F(StateTest, AStandbyWithAHangingDiskContinuesWithoutTheStyle) {
  Begin(WithStyles(2, 10), WithStyles(2, 10));
  SuperviseB(200);
  Send(rig_.Body());
  FramesAndFiles(20);
  files_b_.turns = 1'000'000;
  Like("s", 1, "rig.a");
  FramesAndFiles(40);
  EXPECT_TRUE(b_->State().ready()) << "it waits for half a second";
  FramesAndFiles(120);
  EXPECT_FALSE(b_->State().ready());
  EXPECT_NE(b_->State().why_not().find("styles change at the leader faster"), std::string::npos)
      << b_->State().why_not();
  const std::size_t frames = b_->publisher.frames.size();
  a_.reset();
  wire_.cut = true;
  for (int i = 0; i < 250; ++i) {
    Send(rig_.Frame());
    Turn(8);
  }
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_GT(b_->publisher.frames.size(), frames);
}

// The leader dies while the standby waits for a style: no frame is lost, the style comes later.
TEST_F(StateTest, NothingIsLostIfTheLeaderDiesWhileTheStandbyMakesAStyle) {
  Begin(WithStyles(2, 10), WithStyles(2, 10));
  SuperviseB(200);
  Send(rig_.Body());
  FramesAndFiles(20);
  files_b_.turns = 300;
  Like("s", 1, "rig.a");
  FramesAndFiles(12);
  const auto last = a_->publisher.frames.back().sequence();
  std::map<std::uint64_t, v1::Frame> seen;
  for (const auto& frame : a_->publisher.frames) seen.emplace(frame.sequence(), frame);
  a_.reset();
  FramesAndFiles(40);
  EXPECT_EQ(b_->State().role(), "leading");
  for (const auto& frame : b_->publisher.frames) seen.emplace(frame.sequence(), frame);
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.rbegin()->first - seen.begin()->first + 1, seen.size());
  EXPECT_GT(seen.rbegin()->first, last);
  EXPECT_TRUE(files_b_.running->made.contains("s"));
}

// Each time the style gets another place, and the performer fades over for a minute: out of places
// that no style has any more.
TEST_F(StateTest, ALateStandbyFadesOutOfReplacedStylesLikeTheLeader) {
  config_ = WithStyles(2, 10);
  a_ = std::make_unique<Node>(wire_, true, 5, 1'000'000'000'000, config_, kTopics);
  Turn(1200);
  files_a_.running = files_b_.running = config_;
  Send(rig_.Body());
  FramesAndFiles(10);
  for (int i = 0; i < 5; ++i) {
    Like("s", i, "rig.a", 60'000);
    FramesAndFiles(10);
  }
  StartB(config_);
  FramesAndFiles(250);  // three states, and then one a second
  ASSERT_TRUE(b_->State().ready()) << b_->State().why_not();
  const auto before = b_->State();
  FramesAndFiles(100);
  const auto after = b_->State();
  EXPECT_GT(after.compared() - before.compared(), 80U);
  EXPECT_EQ(after.different() - before.different(), 0U);
  EXPECT_EQ(after.apart() - before.apart(), 0U);
}

// By now the other daemon leads and lacks the style, so no client gets a success reply.
TEST_F(StateTest, AStyleThatIsMadeWhileTheLeadIsLostIsRefused) {
  Begin(WithStyles(2, 10), WithStyles(2, 10));
  SuperviseB(200);
  Send(rig_.Body());
  FramesAndFiles(20);
  files_a_.turns = 300;
  Like("s", 1, "rig.a");
  FramesAndFiles(5);
  v1::Request lead;
  lead.mutable_lead();
  ASSERT_EQ(b_->Ask(lead).code(), v1::CODE_OK);
  FramesAndFiles(30);
  ASSERT_EQ(a_->State().role(), "following");
  FramesAndFiles(20);
  files_a_.turns = 0;
  FramesAndFiles(200);
  std::unique_ptr<pipeline::Exchange> exchange;
  ASSERT_TRUE(a_->mailboxes.replies.Pop(exchange));
  EXPECT_EQ(exchange->reply.code(), v1::CODE_STANDBY);
  EXPECT_FALSE(exchange->reply.has_like());
  EXPECT_TRUE(a_->State().ready()) << a_->State().why_not();
  EXPECT_TRUE(pipeline::PlacesOf(*files_b_.running).entries ==
              pipeline::PlacesOf(*files_a_.running).entries);
}

TEST_F(StateTest, AStyleTooLargeForAMessageIsNamedAndOneDaemonLeads) {
  wire_.max_bytes = 20'000;
  Begin(WithStyles(1, 30'000), WithStyles(0, 0));
  Send(rig_.Body());
  Frames(200);
  ExpectOneLeads();
  EXPECT_FALSE(wire_.cut);
  const v1::StandbyState standby = b_->State();
  EXPECT_FALSE(standby.ready());
  EXPECT_NE(standby.why_not().find("made0"), std::string::npos) << standby.why_not();
  EXPECT_NE(a_->State().too_large().find("made0"), std::string::npos);
  const auto lines = a_->Lines();
  EXPECT_TRUE(std::ranges::any_of(lines, [](const std::string& line) {
    return line.find("cannot stand in: style \"made0\": 3") != std::string::npos;
  })) << testing::PrintToString(lines);
}

TEST_F(StateTest, ARequestTooLargeForAMessageIsNamed) {
  StartB();
  PairTest::Begin();
  Frames(10);
  v1::Request take, restore;
  take.set_performer("rig.a");
  restore.set_performer("rig.a");
  take.mutable_take_checkpoint();
  *restore.mutable_restore_checkpoint()->mutable_checkpoint() = a_->Ask(take).checkpoint();
  wire_.max_bytes = restore.ByteSizeLong() / 2;
  ASSERT_EQ(a_->Ask(restore).code(), v1::CODE_OK);
  Turn(10);
  ExpectOneLeads();
  EXPECT_FALSE(wire_.cut);
  EXPECT_NE(b_->State().why_not().find("a request for rig.a"), std::string::npos)
      << b_->State().why_not();
}

TEST_F(StateTest, SettingsAreSentInParts) {
  for (int i = 0; i < 200; ++i) {
    v1::Request request;
    request.set_performer("rig.p" + std::to_string(i));
    request.mutable_set()->set_strength(0.25F);
    ASSERT_EQ(a_->Ask(request).code(), v1::CODE_OK);
  }
  Count(v1::Journal::kSettings);
  wire_.max_bytes = 20'000;
  StartB();
  ExpectOneLeads();
  EXPECT_FALSE(wire_.cut);
  EXPECT_GE(counted_, 200 / 16);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
  a_.reset();
  Turn(300);
  v1::Request status;
  status.mutable_status();
  const v1::Stats stats = b_->Ask(status).status().stats();
  EXPECT_EQ(stats.standby().role(), "leading");
  ASSERT_EQ(stats.performers_size(), 200);
  for (const auto& row : stats.performers()) {
    EXPECT_EQ(row.look().strength(), 0.25F) << row.performer();
  }
}

// Frames go on while the parts come, and a performer comes between them.
TEST_F(StateTest, APerformerWhoArrivesDuringTheTransferHasTheirSettings) {
  for (const char* const id : {"rig.a", "rig.b", "rig.c"}) {
    v1::Request request;
    request.set_performer(id);
    request.mutable_set()->set_strength(0.5F);
    ASSERT_EQ(a_->Ask(request).code(), v1::CODE_OK);
  }
  b_ = std::make_unique<Node>(wire_, false, 9, 77'000'000'000, config_, kTopics);
  wire_.a_asked = true;
  PairTest::Begin();
  Frames(30);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
  EXPECT_EQ(b_->State().different(), 0U);
  EXPECT_GT(b_->State().compared(), 10U);
}

// Any program may subscribe and request the state. That costs the leader at most one state a
// second, and the standby nothing.
TEST_F(StateTest, TheLeaderSendsItsStateOnceASecondHoweverOftenItIsRequested) {
  StartB();
  PairTest::Begin();
  Frames(125);
  ASSERT_TRUE(b_->State().ready());
  const auto fetched = b_->State().fetched();
  Count(v1::Journal::kBeginning);
  bool stays_ready = true;
  for (int second = 0; second < 5; ++second) {
    for (int i = 0; i < 125; ++i) {
      wire_.a_subscriptions += 8;
      Frames(1);
      stays_ready = stays_ready && b_->State().ready();
    }
  }
  EXPECT_LE(counted_, 3 + 5);
  EXPECT_GE(counted_, 5) << "asked for in earnest, it must come";
  EXPECT_TRUE(stays_ready);
  EXPECT_EQ(b_->State().fetched(), fetched);
  EXPECT_EQ(b_->State().different(), 0U);
  const v1::StandbyState state = a_->State();
  EXPECT_GE(state.asked(), 5000U);
  EXPECT_GE(state.asked_too_often(), 4900U);
  const auto lines = a_->Lines();
  EXPECT_TRUE(std::ranges::any_of(lines, [](const std::string& line) {
    return line.find("who else connects to standby.address?") != std::string::npos;
  })) << testing::PrintToString(lines);
}

TEST_F(StateTest, AThousandSubscriptionsAtOnceTakeMoreThanOneTurn) {
  wire_.a_subscriptions = 1000;
  (void)a_->Step();
  EXPECT_GE(wire_.a_subscriptions, 900);
  Turn(20);
  EXPECT_EQ(wire_.a_subscriptions, 0);
}

// Settings: what decides poses differs, so that they would come out otherwise after a takeover.
TEST_F(StateTest, AStandbyWithOtherFeetSettingsIsNotReadyAndBothReportIt) {
  auto other = std::make_shared<pipeline::RuntimeConfig>(*config_);
  other->stylist.feet = false;
  StartB(other);
  const auto expect_named = [&] {
    const v1::StandbyState state = b_->State();
    EXPECT_FALSE(state.ready());
    EXPECT_NE(state.why_not().find("model.feet: false here, true there"), std::string::npos)
        << state.why_not();
    ASSERT_EQ(a_->State().differs_size(), 1);
    EXPECT_EQ(a_->State().differs(0), "model.feet: true here, false there");
  };
  expect_named();  // before any performer
  PairTest::Begin();
  Frames(61);
  expect_named();
  v1::Request lead;
  lead.mutable_lead();
  EXPECT_EQ(b_->Ask(lead).code(), v1::CODE_NOT_READY);
  a_.reset();  // alone it leads nevertheless, and continues
  Frames(60);
  EXPECT_EQ(b_->State().role(), "leading");
  EXPECT_EQ(b_->State().takeovers(), 0U);
  EXPECT_EQ(b_->publisher.frames.back().sequence(), 121U);
  EXPECT_EQ(b_->publisher.frames.back().epoch(), 5U);
  const auto lines = b_->Lines();
  EXPECT_TRUE(std::ranges::any_of(lines, [](const std::string& line) {
    return line.find("leads, although it was not ready: its configuration differs") !=
           std::string::npos;
  })) << testing::PrintToString(lines);
}

TEST_F(StateTest, WeightsOfAnotherPrecisionAreDetectedBeforeAnyPerformer) {
  auto other = std::make_shared<pipeline::RuntimeConfig>(*config_);
  other->weights_crc = 0x4321;
  StartB(other);
  EXPECT_FALSE(b_->State().ready());
  EXPECT_NE(b_->State().why_not().find("weights: crc32c:00004321 here, crc32c:00001234 there"),
            std::string::npos)
      << b_->State().why_not();
}

// As styled.toml has it: "cues of one name are fired together".
TEST_F(StateTest, CuesOfOneNameAreComparedOneByOne) {
  const auto with_cues = [this](const std::vector<std::string>& styles) {
    auto config = std::make_shared<pipeline::RuntimeConfig>(*config_);
    for (const std::string& style : styles) {
      pipeline::Cue& cue = config->cues.emplace_back();
      cue.name = "duo";
      cue.request.mutable_set()->add_mix()->set_style(style);
    }
    return config;
  };
  const auto same = with_cues({"old", "proud", "old"});
  StartB(same);
  (void)a_->mailboxes.reloads.Push({same, nullptr});
  Turn(1500);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
  (void)b_->mailboxes.reloads.Push({with_cues({"old", "proud", "proud"}), nullptr});
  Turn(1500);
  EXPECT_FALSE(b_->State().ready());
  EXPECT_EQ(b_->State().differs_size(), 1);
  const auto lines = b_->Lines();
  EXPECT_TRUE(std::ranges::any_of(lines, [](const std::string& line) {
    return line.find("cannot stand in: its configuration differs from the leader's: cue duo") !=
           std::string::npos;
  })) << testing::PrintToString(lines);
}

TEST_F(StateTest, AReloadWithEqualSettingsMakesTheStandbyReady) {
  auto other = std::make_shared<pipeline::RuntimeConfig>(*config_);
  other->performers.stale_s = 1;
  StartB(other);
  ASSERT_FALSE(b_->State().ready());
  (void)b_->mailboxes.reloads.Push({config_, nullptr});
  Turn(1500);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
  EXPECT_EQ(a_->State().differs_size(), 0);
  auto changed = std::make_shared<pipeline::RuntimeConfig>(*config_);
  changed->stylist.knees = false;
  (void)a_->mailboxes.reloads.Push({changed, nullptr});
  Turn(10);
  EXPECT_NE(b_->State().why_not().find("model.knees"), std::string::npos);
}

// Poses: nothing that is compared beforehand differs, and yet they do.
TEST_F(StateTest, DifferentPosesMakeTheStandbyUnready) {
  auto other = std::make_shared<pipeline::RuntimeConfig>(*config_);
  other->network = erd::RandomStylizer(5, 4);
  StartB(other);
  PairTest::Begin();
  Wear(*a_, "style2", 0);
  Frames(60);
  const v1::StandbyState state = b_->State();
  EXPECT_GT(state.apart(), 20U);
  EXPECT_FALSE(state.ready());
  EXPECT_NE(state.why_not().find("poses differ from the leader"), std::string::npos)
      << state.why_not();
}

// As on a processor of another make.
TEST_F(StateTest, RoundingDifferencesAreCountedAndTheStandbyStaysReady) {
  wire_.change = [](v1::Journal& entry) {
    if (!entry.has_batch()) return;
    for (v1::Handled& frame : *entry.mutable_batch()->mutable_frames()) {
      frame.set_styled_crc(frame.styled_crc() ^ 1U);
    }
  };
  StartB();
  PairTest::Begin();
  Frames(100);
  const auto fetched = b_->State().fetched();
  Frames(2000);  // longer than the state is fetched again where poses are apart
  const v1::StandbyState state = b_->State();
  EXPECT_EQ(state.different(), state.compared());
  EXPECT_GE(state.compared(), 2000U);
  EXPECT_EQ(state.apart(), 0U);
  EXPECT_TRUE(state.ready()) << state.why_not();
  EXPECT_EQ(state.fetched(), fetched);
}

// The same in earnest: with the instructions of a lesser processor, which round otherwise.
TEST_F(StateTest, AStandbyWithOtherProcessorInstructionsStaysReady) {
  const auto targets = hwy::SupportedAndGeneratedTargets();
  if (targets.size() < 2) GTEST_SKIP() << "one kind of instructions only";
  const auto choose = [](std::int64_t target) {  // 0: as usual
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  choose(targets.back());
  const auto other = MakeConfig();
  choose(0);
  StartB(other);
  PairTest::Begin();
  Wear(*a_, "style2", 300);
  Frames(1200);
  const v1::StandbyState state = b_->State();
  EXPECT_GT(state.different(), 100U) << "the control: they do round otherwise";
  EXPECT_EQ(state.apart(), 0U);
  EXPECT_TRUE(state.ready()) << state.why_not();
}

TEST_F(StateTest, SixOfSixHundredPosesMayDifferAndSevenMayNot) {
  int apart = 6;
  wire_.change = [&apart](v1::Journal& entry) {
    if (!entry.has_batch() || apart == 0) return;
    for (v1::Handled& frame : *entry.mutable_batch()->mutable_frames()) {
      if (frame.is_body()) continue;
      frame.set_styled_crc(frame.styled_crc() ^ 1U);
      frame.mutable_rounded_pose()->assign(frame.rounded_pose().size(), '\x01');
      --apart;
    }
  };
  StartB();
  PairTest::Begin();
  Frames(50);
  EXPECT_EQ(b_->State().apart(), 6U);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
  apart = 1;
  Frames(10);
  EXPECT_EQ(b_->State().apart(), 7U);
  EXPECT_FALSE(b_->State().ready());
  Frames(600);
  EXPECT_TRUE(b_->State().ready()) << b_->State().why_not();
}

// With another hold_ms, the leader's signs of life come more rarely than the standby's hold.
TEST_F(StateTest, AnotherHoldIsReportedAndCausesNoTakeover) {
  config::Standby slow;
  slow.hold_s = 5;
  a_ = std::make_unique<Node>(wire_, true, 5, 1'000'000'000'000, config_, kTopics, false, slow);
  Turn(1200);
  StartB();
  Turn(5000);
  ExpectOneLeads();
  EXPECT_EQ(b_->State().takeovers(), 0U);
  EXPECT_NE(b_->State().why_not().find("standby.hold_ms: 100 here, 5000 there"), std::string::npos)
      << b_->State().why_not();
}

// The least and the most that the configuration allows are no impossible ones to the other daemon.
TEST_F(StateTest, TheHeartbeatsOfEveryAllowedHoldAreHeard) {
  for (const float hold_s : {0.02F, 0.0333F, 1.7F, 5.0F}) {
    config::Standby settings;
    settings.hold_s = hold_s;
    wire_ = Wire();
    a_ = std::make_unique<Node>(wire_, true, 5, 1'000'000'000'000, config_, kTopics, false,
                                settings);
    b_ = nullptr;
    Turn(1200);
    b_ = std::make_unique<Node>(wire_, false, 9, 77'000'000'000, config_, kTopics, false, settings);
    wire_.a_asked = true;
    Turn(2000);
    ExpectOneLeads();
    EXPECT_TRUE(b_->State().ready()) << hold_s << ": " << b_->State().why_not();
    EXPECT_EQ(b_->State().refused() + a_->State().refused(), 0U) << hold_s;
  }
}

}  // namespace
}  // namespace styled::support
