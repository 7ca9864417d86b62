#include "daemon/pipeline/pipeline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>

#include "model/base/crc32c.h"
#include "proto/styled/look.h"
#include "tests/support/fake_pipeline.h"
#include "tests/support/native_frames.h"
#include "tests/support/rig.h"
#include "tests/support/units.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using support::kMs;

// The pipeline with a clock that the test moves, no sockets and no sleep.
class PipelineTest : public testing::Test {
 protected:
  PipelineTest() { publisher_.events.push_back({true, "styled/rig.a/rig/"}); }

  std::shared_ptr<RuntimeConfig> MakeConfig() const {
    auto live = std::make_shared<RuntimeConfig>();
    live->network = network_;
    live->weights_name = "random";
    live->performers = limits_;
    return live;
  }
  Pipeline& pipeline() {
    if (pipeline_ == nullptr) {
      pipeline_ = std::make_unique<Pipeline>(
          Dependencies{clock_, counters_, publisher_, mailboxes_}, std::vector<std::string>{"rig"},
          std::vector<std::unique_ptr<source::Transport>>(), MakeConfig(), 77, 100);
      Work();
    }
    return *pipeline_;
  }
  void Work() {
    while (pipeline_->DoWork() > 0) {
    }
  }
  void Deliver(const std::vector<support::Bytes>& datagrams) {
    std::vector<std::span<const std::byte>> spans(datagrams.begin(), datagrams.end());
    support::HandOn(spans, {}, counters_, pipeline());
    Work();
  }
  void Pass(std::int64_t ms) {
    clock_.now_ns += ms * kMs;
    pipeline();
    Work();
  }
  v1::Reply Ask(const v1::Request& request) {
    auto exchange = std::make_unique<Exchange>();
    exchange->request = request;
    EXPECT_TRUE(mailboxes_.commands.Push(std::move(exchange)));
    pipeline();
    Work();
    EXPECT_TRUE(mailboxes_.replies.Pop(exchange));
    return exchange->reply;
  }
  std::uint64_t Count(Counter counter) const { return counters_.Get(counter); }
  const std::vector<v1::Frame>& frames() const { return publisher_.frames; }

  std::shared_ptr<const net::Stylizer> network_ = erd::RandomStylizer(5, 1);
  config::Performers limits_;
  support::FakeClock clock_;
  runtime::Counters counters_;
  support::FakePublisher publisher_;
  Mailboxes mailboxes_;
  support::Rig rig_{"a"};
  std::unique_ptr<Pipeline> pipeline_;
};

TEST_F(PipelineTest, AFrameIsSentInTheCallThatReceivesIt) {
  Deliver({rig_.Body(), rig_.Frame()});
  ASSERT_EQ(frames().size(), 1U);
  EXPECT_EQ(frames()[0].sequence(), 1U);
  EXPECT_EQ(frames()[0].epoch(), 77U);
  EXPECT_EQ(frames()[0].performer(), "rig.a");
}

// The bytes published for 40 performers' frames, in order, with so many helpers.
std::vector<std::string> PublishedOfACrowd(int helper_count) {
  constexpr int kPerformers = 40;
  runtime::Helpers helpers(helper_count);
  auto config = std::make_shared<RuntimeConfig>();
  config->network = erd::RandomStylizer(5, 1);
  config->style.initial = "style1";
  support::FakePipeline pipeline(config, "styled/", {"rig"},
                                 helper_count == 0 ? nullptr : &helpers);
  std::vector<support::Rig> rigs;
  for (int i = 0; i < kPerformers; ++i) rigs.emplace_back("p" + std::to_string(i), 7 + i);
  std::vector<support::Bytes> datagrams;
  for (int frame = 0; frame < 40; ++frame) {
    for (support::Rig& rig : rigs) datagrams.push_back(frame == 0 ? rig.Body() : rig.Frame());
  }
  for (std::size_t from = 0; from < datagrams.size(); from += source::kBatch) {
    const std::size_t to = std::min(from + source::kBatch, datagrams.size());
    pipeline.Deliver({datagrams.begin() + static_cast<std::ptrdiff_t>(from),
                      datagrams.begin() + static_cast<std::ptrdiff_t>(to)});
  }
  std::vector<std::string> published;
  for (const auto& frame : pipeline.publisher.frames) {
    published.push_back(frame.SerializeAsString());
  }
  return published;
}

TEST(PipelineHelpersTest, TheySendTheSameBytesInTheSameOrder) {
  const std::vector<std::string> alone = PublishedOfACrowd(0);
  EXPECT_EQ(alone.size(), 2U * 39 * 40);  // topics, frames, performers
  for (const int helpers : {1, 3}) {
    EXPECT_TRUE(PublishedOfACrowd(helpers) == alone) << helpers << " helpers";
  }
}

TEST_F(PipelineTest, ABodyInOtherUnitsHasAnotherHash) {
  v1::Body body = rig_.MakeBody();
  for (const float unit_m : {1.0F, 0.01F}) {
    body.set_metres_per_unit(unit_m);
    Deliver({rig_.Datagram(native::Kind::kBody, body.SerializeAsString()), rig_.Frame()});
  }
  ASSERT_EQ(frames().size(), 2U);
  EXPECT_NE(frames()[0].body_hash(), frames()[1].body_hash());
}

TEST_F(PipelineTest, AUnitThatIsNotALengthIsRefused) {
  v1::Body body = rig_.MakeBody();
  for (const float unit_m :
       {-1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    body.set_metres_per_unit(unit_m);
    Deliver({rig_.Datagram(native::Kind::kBody, body.SerializeAsString()), rig_.Frame()});
  }
  EXPECT_EQ(Count(Counter::kPipelineBodiesRefused), 3U);
  EXPECT_TRUE(frames().empty());
}

TEST_F(PipelineTest, ForeignTextIsQuotedWithoutControlCharacters) {
  v1::Body body = rig_.MakeBody();
  body.set_dialect("a\nb\x1b[31m");
  Deliver({rig_.Datagram(native::Kind::kBody, body.SerializeAsString())});
  Event event;
  ASSERT_TRUE(mailboxes_.events.Pop(event));
  EXPECT_NE(event.text.find("found dialect a\\nb\\x1b[31m"), std::string::npos) << event.text;
}

TEST_F(PipelineTest, LateFramesArePublishedUpToTheBacklogAndThenOnlyTheNewest) {
  Deliver({rig_.Body(), rig_.Frame()});
  for (int i = 0; i < 20; ++i) {
    Pass(8);
    Deliver({rig_.Frame()});
  }
  publisher_.frames.clear();
  // 80 ms pile up: all come, the early ones late.
  std::vector<support::Bytes> pile;
  for (int i = 0; i < 10; ++i) pile.push_back(rig_.Frame());
  Pass(80);
  Deliver(pile);
  ASSERT_EQ(frames().size(), 10U);
  EXPECT_EQ(frames().front().flags() & v1::FLAG_LATE, v1::FLAG_LATE);
  EXPECT_EQ(frames().back().flags() & v1::FLAG_LATE, 0U);
  // 200 ms pile up, and then 120 ms of nothing: only the newest.
  publisher_.frames.clear();
  pile.clear();
  for (int i = 0; i < 24; ++i) pile.push_back(rig_.Frame());
  Pass(320);
  publisher_.frames.clear();  // the stale one
  Deliver(pile);
  ASSERT_EQ(frames().size(), 1U);
  EXPECT_EQ(frames()[0].source_sequence(), rig_.sequence - 1);
  EXPECT_NE(frames()[0].flags() & v1::FLAG_LATE, 0U);
  EXPECT_NE(frames()[0].flags() & v1::FLAG_CONCEALED, 0U) << "the rest is a gap";
  EXPECT_EQ(Count(Counter::kPipelineBacklogDropped), 23U);
}

// A clock on which every look takes its time.
struct SlowClock final : runtime::Clock {
  std::int64_t Now_ns() const noexcept override { return now_ns += look_ns; }
  std::int64_t Wall_ns() const noexcept override { return now_ns; }
  mutable std::int64_t now_ns = 1'000'000 * kMs;
  std::int64_t look_ns = 0;
};

TEST_F(PipelineTest, CyclesLongerThanAFrameAreCounted) {
  SlowClock clock;
  Pipeline slow(Dependencies{clock, counters_, publisher_, mailboxes_}, {"rig"}, {}, MakeConfig(),
                77, 100);
  const auto cycle = [&](std::int64_t look_ns) {
    auto exchange = std::make_unique<Exchange>();
    exchange->request.mutable_status();
    ASSERT_TRUE(mailboxes_.commands.Push(std::move(exchange)));
    clock.look_ns = look_ns;
    ASSERT_GT(slow.DoWork(), 0);
    ASSERT_TRUE(mailboxes_.replies.Pop(exchange));
  };
  cycle(0);
  cycle(100'000);
  EXPECT_EQ(Count(Counter::kPipelineOverBudget), 0U);
  cycle(9 * kMs);
  cycle(9 * kMs);
  EXPECT_EQ(Count(Counter::kPipelineOverBudget), 2U);
}

TEST_F(PipelineTest, AStepOfTheWallClockIsReportedOnceAndMakesNoFrameLate) {
  Deliver({rig_.Body(), rig_.Frame()});
  Pass(1000);
  const std::int64_t before_ns = clock_.Wall_ns();
  clock_.wall_ahead_ns -= 3'600'000 * kMs;
  Pass(1000);
  Pass(1000);
  Deliver({rig_.Frame()});
  EXPECT_EQ(Count(Counter::kPipelineWallClockSteps), 1U);
  std::string lines;
  for (Event event; mailboxes_.events.Pop(event);) lines += event.text + "\n";
  EXPECT_NE(lines.find("the wall clock was set by -3600.000 s"), std::string::npos) << lines;
  EXPECT_EQ(Count(Counter::kPipelineOverBudgetFrames), 0U);
  EXPECT_EQ(static_cast<std::int64_t>(frames().back().wall_time_ns()),
            before_ns + (2000 - 3'600'000) * kMs);
}

// A datagram that waited in the kernel while the daemon stood still.
TEST_F(PipelineTest, AFrameThatLeavesAPeriodAfterItsArrivalIsCounted) {
  Deliver({rig_.Body(), rig_.Frame()});
  const auto deliver = [this](std::int64_t waited_ms) {
    Pass(8);
    const support::Bytes frame = rig_.Frame();
    const std::span<const std::byte> bytes(frame);
    const std::int64_t arrival_ns = clock_.now_ns - waited_ms * kMs;
    source::NativeDecoder(0, counters_).HandOn({&bytes, 1}, {}, pipeline(), {&arrival_ns, 1});
  };
  deliver(8);
  EXPECT_EQ(Count(Counter::kPipelineOverBudgetFrames), 0U);
  deliver(9);
  deliver(150);
  EXPECT_EQ(Count(Counter::kPipelineOverBudgetFrames), 2U);
  EXPECT_EQ(counters_.ClearSources(Counter::kPipelineOverBudgetFrames), 1U);
  const auto& last = frames().back();
  EXPECT_EQ(last.publish_time_ns() - last.receive_time_ns(), std::uint64_t{150 * kMs});
  Pass(1000);
  v1::Request request;
  request.mutable_status();
  const v1::Reply reply = Ask(request);
  const auto& performer = reply.status().stats().performers(0);
  EXPECT_EQ(performer.over_budget(), 2U);
  EXPECT_NEAR(performer.period_ms(), 8.33F, 0.01F);
  EXPECT_GT(performer.latency_max_us(), 149'000);
}

TEST_F(PipelineTest, SilenceIsStaleOnceThenNothingThenForgotten) {
  Deliver({rig_.Body(), rig_.Frame()});
  Pass(249);
  EXPECT_EQ(frames().size(), 1U);
  EXPECT_EQ(pipeline().NextDeadline_ns(), clock_.now_ns + 1 * kMs);
  Pass(1);
  ASSERT_EQ(frames().size(), 2U);
  EXPECT_EQ(frames()[1].flags() & v1::FLAG_STALE, v1::FLAG_STALE);
  Pass(30'000);
  EXPECT_EQ(frames().size(), 2U);
  EXPECT_EQ(Count(Counter::kPipelinePerformers), 1U);
  Pass(29'750);
  EXPECT_EQ(Count(Counter::kPipelinePerformers), 0U);
  // The performer returns: its sequence continues.
  Deliver({rig_.Body(), rig_.Frame()});
  ASSERT_EQ(frames().size(), 3U);
  EXPECT_EQ(frames()[2].sequence(), 3U);
}

TEST_F(PipelineTest, TheReplyNamesTheFirstSequenceUnderTheChange) {
  Deliver({rig_.Body(), rig_.Frame(), rig_.Frame()});
  v1::Request request;
  request.set_performer("rig.a");
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style("S1");
  mix.set_weight(1);
  request.mutable_set()->set_transition_ms(0);
  const v1::Reply reply = Ask(request);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  EXPECT_EQ(reply.applied(0).first_sequence(), 3U);
  Deliver({rig_.Frame()});
  ASSERT_EQ(frames()[2].sequence(), 3U);
  ASSERT_EQ(frames()[2].styles_size(), 1);
  EXPECT_EQ(frames()[2].styles(0).style(), "style1");
}

TEST_F(PipelineTest, TheReplyNamesAbsentPerformersAndStylesWithoutStrength) {
  Deliver({rig_.Body(), rig_.Frame()});
  v1::Request request;
  request.mutable_set()->add_mix()->set_style("S1");
  request.mutable_set()->mutable_mix(0)->set_weight(1);
  const auto ask = [&](const std::string& performer, float strength) {
    request.set_performer(performer);
    request.mutable_set()->set_strength(strength);
    const v1::Reply reply = Ask(request);
    EXPECT_EQ(reply.applied_size(), 1) << reply.reason();
    return reply.applied(0);
  };
  EXPECT_FALSE(ask("rig.a", 1).absent());
  EXPECT_FALSE(ask("rig.a", 1).no_strength());
  EXPECT_TRUE(ask("rig.a", 0).no_strength());
  EXPECT_TRUE(ask("rig.an", 1).absent());
  EXPECT_FALSE(ask("rig.an", 1).no_strength());
}

TEST_F(PipelineTest, StatusTellsHowMuchOfTheStyleIsShown) {
  Deliver({rig_.Body(), rig_.Frame()});
  v1::Request status;
  status.mutable_status();
  const auto row = [&] {
    Pass(1000);
    return Ask(status).status().stats().performers(0);
  };
  EXPECT_FALSE(row().has_turned_deg()) << "nothing is styled";
  v1::Request request;
  request.set_performer("rig.a");
  request.mutable_set()->add_mix()->set_style("S1");
  request.mutable_set()->mutable_mix(0)->set_weight(1);
  ASSERT_EQ(Ask(request).code(), v1::CODE_OK);
  for (int i = 0; i < 60; ++i) Deliver({rig_.Frame()});
  const v1::PerformerStats styled = row();
  ASSERT_TRUE(styled.has_turned_deg());
  EXPECT_GT(styled.turned_deg(), 0);
  EXPECT_LT(styled.turned_deg(), 180);
  EXPECT_LE(styled.shown().trunk(), 1);
  EXPECT_GT(styled.moved().hands(), 0);
  EXPECT_LT(styled.moved().hands(), 1.5F) << "a random network's style";
  EXPECT_TRUE(styled.hardly_styled());
}

TEST_F(PipelineTest, AMissingStyleIsAWarningUntilAnotherIsChosen) {
  Profile kept;
  kept.id = "rig.a";
  kept.look = InitialLook();
  kept.look.add_mix()->set_style("mine");
  kept.look.mutable_mix(0)->set_weight(1);
  pipeline().Restore({kept});
  Deliver({rig_.Body(), rig_.Frame()});
  v1::Request request;
  const auto warning = [&] {
    request.mutable_status();
    return Ask(request).status().stats().performers(0).warning();
  };
  EXPECT_EQ(warning(), "no style \"mine\" is here any more, and it has no effect: choose another");
  request.set_performer("rig.a");
  request.mutable_set()->add_mix()->set_style("S1");
  request.mutable_set()->mutable_mix(0)->set_weight(1);
  ASSERT_EQ(Ask(request).code(), v1::CODE_OK);
  EXPECT_EQ(warning(), "");
}

// Styled together or one by one: the same frames. One performer has two frames in each batch.
TEST_F(PipelineTest, ACrowdInOneBatchIsStyledAsEachAlone) {
  const auto run = [this](bool together) {
    pipeline_.reset();
    publisher_.frames.clear();
    publisher_.events.push_back({true, "styled/"});
    std::vector<support::Rig> rigs;
    for (int k = 0; k < 11; ++k) {
      rigs.emplace_back("p" + std::to_string(k));
      rigs.back().time_ns += static_cast<std::uint64_t>(k) * 300'000'000;  // each elsewhere
      Deliver({rigs.back().Body()});
    }
    v1::Request request;
    request.set_performer("*");
    auto& style = *request.mutable_set()->add_mix();
    style.set_style("style1");
    style.set_weight(1);
    EXPECT_EQ(Ask(request).code(), v1::CODE_OK);
    for (int frame = 0; frame < 30; ++frame) {
      std::vector<support::Bytes> batch;
      for (auto& rig : rigs) batch.push_back(rig.Frame());
      batch.push_back(rigs[4].Frame());
      if (together) {
        Deliver(batch);
      } else {
        for (const auto& datagram : batch) Deliver({datagram});
      }
    }
    std::map<std::pair<std::string, std::uint64_t>, std::string> frames;
    for (v1::Frame& frame : publisher_.frames) {
      const std::string bytes = frame.SerializeAsString();
      frames[{frame.performer(), frame.sequence()}] = bytes;
    }
    return frames;
  };
  const auto together = run(true);
  const auto alone = run(false);
  EXPECT_EQ(together.size(), 12U * 30U);
  EXPECT_TRUE(together == alone);
}

// Twelve performers who send at once: more than are styled together.
TEST_F(PipelineTest, ABundleHasTheFramesOfACycleAsEachTopicHasThem) {
  publisher_.events.push_back({true, "styled/"});
  publisher_.events.push_back({true, "frames/canonical/"});
  std::vector<support::Rig> rigs;
  for (int i = 0; i < 12; ++i) rigs.emplace_back("p" + std::to_string(i), 7 + i);
  std::vector<support::Bytes> datagrams;
  for (auto& rig : rigs) datagrams.push_back(rig.Body());
  Deliver(datagrams);
  for (int cycle = 1; cycle <= 3; ++cycle) {
    datagrams.clear();
    for (auto& rig : rigs) datagrams.push_back(rig.Frame());
    publisher_.frames.clear();
    publisher_.bundles.clear();
    Deliver(datagrams);
    ASSERT_EQ(publisher_.bundles.size(), 1U);
    EXPECT_EQ(publisher_.bundles[0].first, "frames/canonical/");
    std::vector<std::string> bundled, alone;
    for (const auto& frame : publisher_.bundles[0].second.frames()) {
      bundled.push_back(frame.SerializeAsString());
    }
    for (const auto& frame : publisher_.frames) {
      if (frame.output() == v1::OUTPUT_CANONICAL) alone.push_back(frame.SerializeAsString());
    }
    EXPECT_EQ(bundled.size(), rigs.size());
    EXPECT_EQ(bundled, alone);
  }
  clock_.now_ns += 20'000 * kMs;
  publisher_.bundles.clear();
  Work();
  EXPECT_FALSE(publisher_.bundles.empty()) << "the stale frames are in bundles, too";
}

TEST_F(PipelineTest, FramesForABundleAloneAreNotSentTwice) {
  publisher_.events.clear();
  publisher_.events.push_back({true, "frames/rig/"});
  Deliver({rig_.Body()});
  Deliver({rig_.Frame()});
  EXPECT_TRUE(frames().empty());
  ASSERT_EQ(publisher_.bundles.size(), 1U);
  EXPECT_EQ(publisher_.bundles[0].second.frames_size(), 1);
}

TEST_F(PipelineTest, ColdCachesAreWarmedShortlyBeforeAFrameIsDue) {
  Deliver({rig_.Body(), rig_.Frame()});
  clock_.now_ns += static_cast<std::int64_t>(rig_.period_ns);
  Deliver({rig_.Frame()});
  const std::int64_t due_ns = clock_.now_ns + static_cast<std::int64_t>(rig_.period_ns);
  EXPECT_EQ(pipeline().NextDeadline_ns(), due_ns - decide::Anticipation::kLead_ns);
  clock_.now_ns = due_ns - decide::Anticipation::kLead_ns - 1;
  Work();
  EXPECT_EQ(Count(Counter::kPipelinePrewarmed), 0U);
  EXPECT_FALSE(pipeline().Expects(clock_.now_ns));
  clock_.now_ns += 1;
  Work();
  EXPECT_EQ(Count(Counter::kPipelinePrewarmed), 1U);
  EXPECT_TRUE(pipeline().Expects(clock_.now_ns));
  EXPECT_GT(pipeline().NextDeadline_ns(), due_ns);
  Work();
  EXPECT_EQ(Count(Counter::kPipelinePrewarmed), 1U) << "once a frame";
  clock_.now_ns = due_ns;
  Deliver({rig_.Frame()});
  EXPECT_FALSE(pipeline().Expects(clock_.now_ns));
}

// To be woken for each frame of a crowd costs more than the frames.
TEST_F(PipelineTest, WarmCachesCauseNoWakeup) {
  support::Rig other("b");
  Deliver({rig_.Body(), other.Body()});
  for (int i = 0; i < 3; ++i) {
    Deliver({rig_.Frame()});
    clock_.now_ns += static_cast<std::int64_t>(rig_.period_ns) - kMs;
    Deliver({other.Frame()});  // 1 ms before the first one's next frame
    const std::int64_t next_ns = pipeline().NextDeadline_ns();
    EXPECT_GT(next_ns, clock_.now_ns + 2 * kMs) << i;
    clock_.now_ns += kMs;
    Work();
  }
  EXPECT_EQ(Count(Counter::kPipelinePrewarmed), 0U);
  Deliver({rig_.Frame()});
  EXPECT_LT(pipeline().NextDeadline_ns(), clock_.now_ns + static_cast<std::int64_t>(rig_.period_ns))
      << "the other one's is a while ahead";
}

TEST_F(PipelineTest, ABodyThatFramesOvertookIsAccepted) {
  const support::Bytes body = rig_.Body();
  const support::Bytes first = rig_.Frame();
  Deliver({rig_.Frame()});
  EXPECT_EQ(Count(Counter::kPipelineBeforeBody), 1U);
  Deliver({first, body, rig_.Frame()});
  EXPECT_EQ(frames().size(), 1U);
  EXPECT_EQ(Count(Counter::kPipelineBeforeBody), 2U);
}

TEST_F(PipelineTest, ANewSessionMayNameTheLastBodyByItsChecksum) {
  const support::Bytes body = rig_.Body();
  Deliver({body, rig_.Frame()});
  Pass(150);
  support::Rig restarted("a", 99);
  restarted.sequence = 1;  // its body was lost
  Deliver({restarted.Frame()});
  EXPECT_EQ(Count(Counter::kPipelineBeforeBody), 1U);
  const auto payload = std::span(body).subspan(native::kHeaderSize);
  Deliver({restarted.Frame([&](v1::SourceFrame& f) { f.set_body_crc(Crc32c(payload)); })});
  ASSERT_EQ(frames().size(), 2U);
  EXPECT_EQ(frames()[1].flags() & v1::FLAG_NEW_SESSION, v1::FLAG_NEW_SESSION);
}

TEST_F(PipelineTest, BodiesGoOutOnChangeOnceASecondAndToNewSubscribers) {
  Deliver({rig_.Body()});
  EXPECT_EQ(publisher_.bodies, 0) << "nobody subscribed to them";
  publisher_.events.push_back({true, "body/"});
  Pass(0);
  EXPECT_EQ(publisher_.bodies, 2);
  publisher_.events.push_back({true, "body/"});
  Pass(0);
  EXPECT_EQ(publisher_.bodies, 4) << "the second subscriber too";
  Pass(1000);
  EXPECT_EQ(publisher_.bodies, 6);
}

TEST_F(PipelineTest, NewWeightsKeepLooksByName) {
  v1::Request request;
  request.set_performer("*");
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style("style1");
  mix.set_weight(0.5F);
  request.mutable_set()->set_transition_ms(0);
  ASSERT_EQ(Ask(request).code(), v1::CODE_OK);
  Deliver({rig_.Body(), rig_.Frame()});
  ASSERT_EQ(frames()[0].styles_size(), 1);
  network_ = erd::RandomStylizer(3, 9);
  std::shared_ptr<const RuntimeConfig> config = MakeConfig();
  ASSERT_TRUE(mailboxes_.reloads.Push({std::move(config), nullptr}));
  Pass(8);
  Deliver({rig_.Frame()});
  ASSERT_EQ(frames().size(), 2U);
  ASSERT_EQ(frames()[1].styles_size(), 1);
  EXPECT_EQ(frames()[1].styles(0).style(), "style1");
}

}  // namespace
}  // namespace styled::pipeline
