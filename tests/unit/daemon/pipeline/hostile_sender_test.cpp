// Effects of senders on themselves and on others: clocks, counters, sessions, skeletons. Beside
// each a victim sends at 120 Hz and must not notice.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "model/stylist/stylist.h"
#include "tests/support/fake_pipeline.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using support::Bytes;
using support::Rig;

constexpr source::Machine kHere{0x0A}, kElsewhere{0x0B};
constexpr std::uint64_t kMs_u = 1'000'000;

std::shared_ptr<RuntimeConfig> MakeConfig() {
  static const std::shared_ptr<const net::Stylizer> network = erd::RandomStylizer(5, 1);
  auto live = std::make_shared<RuntimeConfig>();
  live->network = network;
  return live;
}

struct HostileSenderTest : testing::Test {
  support::FakePipeline stage{MakeConfig(), "styled/"};
  Rig victim{"victim", 101};
  std::uint64_t most_steps = 0;  // of the network, in one delivery

  void Deliver(const std::vector<Bytes>& datagrams, const source::Machine& from = kHere) {
    const std::uint64_t before = stage.Count(Counter::kStylistSteps);
    stage.Deliver(datagrams, from);
    most_steps = std::max(most_steps, stage.Count(Counter::kStylistSteps) - before);
  }
  // 1/120 s later a frame of the victim.
  void VictimSends() {
    stage.clock.now_ns += static_cast<std::int64_t>(victim.period_ns);
    Deliver({victim.Frame()});
  }
  // Frames of the performer that left, and those of them that are no repetition of a last pose.
  std::size_t Left(const std::string& id) const {
    std::size_t count = 0;
    for (const v1::Frame& frame : stage.publisher.frames) {
      count += frame.performer() == id && frame.output() == v1::OUTPUT_RIG &&
                       (frame.flags() & v1::FLAG_STALE) == 0
                   ? 1
                   : 0;
    }
    return count;
  }
};

Bytes FrameAt(Rig& rig, std::uint64_t time_ns) {
  return rig.Frame([time_ns](v1::SourceFrame& frame) { frame.set_source_time_ns(time_ns); });
}

// The clock of every frame is 10 s to an hour ahead of the last one's, so that the gap looks usual.
TEST_F(HostileSenderTest, AClockThatStepsCostsTheOthersNothing) {
  Deliver({victim.Body(), victim.Frame()});
  for (const std::uint64_t step_s : {1ULL, 10ULL, 1000ULL, 3600ULL, 4000ULL}) {
    Rig evil("evil" + std::to_string(step_s), step_s + 1000);
    Deliver({evil.Body()}, kElsewhere);
    std::uint64_t time_ns = 1;
    for (int i = 0; i < 40; ++i) {
      VictimSends();
      time_ns += step_s * 1000 * kMs_u;
      Deliver({FrameAt(evil, time_ns)}, kElsewhere);
    }
    EXPECT_EQ(Left("rig." + evil.performer), 40U) << "it is styled all the same";
  }
  EXPECT_EQ(Left("rig.victim"), 201U);
  EXPECT_LE(most_steps, 2U);
}

// Twelve such frames in one batch.
TEST_F(HostileSenderTest, ABatchOfSteppingClocksIsNoMoreWorkThanItsFrames) {
  Rig evil("evil", 9);
  Deliver({evil.Body()});
  std::vector<Bytes> batch;
  for (std::uint64_t i = 1; i <= 12; ++i) batch.push_back(FrameAt(evil, i * 1'000'000 * kMs_u));
  Deliver(batch);
  EXPECT_LE(most_steps, 12U);
}

// The property: whatever the source times, a frame takes no more than kMaxStepsPerFrame, n frames
// in a row no more than that and kMeanStepsPerFrame each.
TEST_F(HostileSenderTest, NoSequenceOfSourceTimesTakesMoreThanTheStatedSteps) {
  std::mt19937_64 random(18);
  Deliver({victim.Body(), victim.Frame()});
  const std::uint64_t limit = stylist::kMaxStepsPerFrame;
  int clocks = 0, hardest = 0;
  for (; clocks < 1000; ++clocks) {
    Rig evil("evil" + std::to_string(clocks % 8), 2000 + static_cast<std::uint64_t>(clocks) * 17);
    stage.clock.now_ns += 200'000'000;  // the one before was silent: this one may take over
    VictimSends();
    Deliver({evil.Body()}, kElsewhere);
    std::uint64_t time_ns = random() % 2 == 0 ? random() : random() % 1'000'000'000;
    // Each clock has habits of its own: two to four steps that it takes by turns or by chance.
    std::vector<std::uint64_t> steps;
    for (std::uint64_t k = 2 + random() % 3; k > 0; --k) {
      const double exponent = static_cast<double>(random() % 1000) / 1000 * 13;  // 1 ns to 3 h
      steps.push_back(static_cast<std::uint64_t>(std::pow(10.0, exponent)));
    }
    const bool backwards = random() % 4 == 0;
    const bool by_turns = random() % 2 == 0;
    const std::uint64_t before = stage.Count(Counter::kStylistSteps);
    std::uint64_t frames = 0, took = 0;
    for (std::size_t i = 0; i < 40; ++i) {
      VictimSends();
      const std::uint64_t step = steps[(by_turns ? i : random()) % steps.size()];
      time_ns = backwards && random() % 3 == 0 ? time_ns - step : time_ns + step;
      const std::uint64_t so_far = stage.Count(Counter::kStylistSteps);
      Deliver({FrameAt(evil, time_ns)}, kElsewhere);
      took += stage.Count(Counter::kStylistSteps) - so_far;
      ++frames;
      ASSERT_LE(stage.Count(Counter::kStylistSteps) - so_far, limit);
    }
    hardest = std::max(hardest, static_cast<int>(took));
    ASSERT_LE(took, limit + stylist::kMeanStepsPerFrame * frames);
    (void)before;
  }
  EXPECT_EQ(Left("rig.victim"), 1U + 1000U * 41U) << "no frame of the victim is lost";
  EXPECT_GT(hardest, 40) << "some clocks must be hard";
}

// A gap that is bridged at 240 Hz still is.
TEST_F(HostileSenderTest, AnHonestGapIsStillBridged) {
  Rig rig("a", 5);
  rig.period_ns = 1'000'000'000 / 240;
  Deliver({rig.Body()});
  for (int i = 0; i < 100; ++i) Deliver({rig.Frame()});
  rig.time_ns += 240 * kMs_u;
  Deliver({rig.Frame()});
  EXPECT_GE(most_steps, 55U);
  EXPECT_EQ(stage.publisher.frames.back().flags() & v1::FLAG_CONCEALED, v1::FLAG_CONCEALED);
}

TEST_F(HostileSenderTest, ASequenceFromTheFutureSilencesNoPerformer) {
  Deliver({victim.Body(), victim.Frame()});
  const std::uint64_t next = victim.sequence;
  victim.sequence = 1'000'000'000;
  Deliver({victim.Frame()});
  victim.sequence = next;
  for (int i = 0; i < 100; ++i) VictimSends();
  EXPECT_EQ(Left("rig.victim"), 101U);
  EXPECT_EQ(stage.StatsOf("rig.victim").lost(), 0U);
  EXPECT_EQ(stage.Count(Counter::kPipelineFarAhead), 1U);
}

TEST_F(HostileSenderTest, ASenderThatRestartsUnderItsSessionIdIsBackWithin200ms) {
  Deliver({victim.Body(), victim.Frame()});
  for (int i = 0; i < 500; ++i) VictimSends();
  const std::size_t before = Left("rig.victim");
  victim.sequence = 0;
  victim.time_ns = 1;
  Deliver({victim.Body()});
  for (int i = 0; i < 120; ++i) VictimSends();
  EXPECT_GE(Left("rig.victim"), before + 120 - 24);
  EXPECT_EQ(stage.Count(Counter::kPipelineRecounts), 1U);
  EXPECT_EQ(stage.StatsOf("rig.victim").lost(), 0U);
}

TEST_F(HostileSenderTest, AStolenSessionIdFromAnotherMachineChangesNothing) {
  Deliver({victim.Body(), victim.Frame()});
  for (int i = 0; i < 200; ++i) {
    VictimSends();
    Rig thief("victim", victim.session + (i % 2 == 0 ? 0 : decide::kSessionStep));
    thief.sequence = victim.sequence + static_cast<std::uint64_t>(i);
    thief.time_ns = victim.time_ns + 1000 * kMs_u;
    Deliver({thief.Body(), thief.Frame()}, kElsewhere);
  }
  EXPECT_EQ(Left("rig.victim"), 201U);
  EXPECT_EQ(stage.Count(Counter::kPipelineSecondSender), 400U);
  EXPECT_EQ(stage.Count(Counter::kPipelineSessions), 1U);
}

// The report of status and doctor about a performer whose datagrams arrive and whose frames are not
// published.
TEST_F(HostileSenderTest, LiveMeansThatFramesLeaveAndOtherwiseTheReasonIsGiven) {
  Deliver({victim.Body(), victim.Frame()});
  VictimSends();
  EXPECT_TRUE(stage.StatsOf("rig.victim").live());
  for (int i = 0; i < 240; ++i) {  // the same datagram again and again
    stage.clock.now_ns += static_cast<std::int64_t>(victim.period_ns);
    --victim.sequence;
    Deliver({victim.Frame()});
  }
  const v1::PerformerStats stats = stage.StatsOf("rig.victim");
  EXPECT_FALSE(stats.live());
  EXPECT_EQ(stats.refused(), 240U);
  EXPECT_EQ(stats.refused_as(), "pipeline.duplicate");
  EXPECT_EQ(stats.rate_hz(), 0.0F);
}

TEST_F(HostileSenderTest, ARigOf1HzIsLiveAtItsRateAndNotRepeated) {
  Rig slow("slow", 3);
  slow.period_ns = 1'000'000'000;
  Deliver({slow.Body(), slow.Frame()});
  for (int s = 0; s < 30; ++s) {
    for (int ms = 0; ms < 1000; ms += 10) {
      stage.Pass(10);
      if (s < 5) continue;
      const v1::PerformerStats stats = stage.StatsOf("rig.slow");
      ASSERT_TRUE(stats.live()) << s << " s " << ms;
      ASSERT_NEAR(stats.rate_hz(), 1, 0.1) << s << " s " << ms;
    }
    Deliver({slow.Frame()});
  }
  EXPECT_EQ(stage.StatsOf("rig.slow").published(), 31U);
  EXPECT_LE(stage.Count(Counter::kPipelineStale), 2U) << "before its rate was known";
}

// From the first sample on, and again after a silence.
TEST_F(HostileSenderTest, TheRateIsCorrectAtOnce) {
  for (const int rate_hz : {30, 120, 3}) {
    Rig rig("r" + std::to_string(rate_hz), 3);
    rig.period_ns = 1'000'000'000 / static_cast<std::uint64_t>(rate_hz);
    for (int round = 0; round < 2; ++round) {
      Deliver({rig.Body()});
      for (int i = 0; i < 5 * rate_hz; ++i) {
        stage.clock.now_ns += static_cast<std::int64_t>(rig.period_ns);
        Deliver({rig.Frame()});
        const float found = stage.StatsOf("rig." + rig.performer).rate_hz();
        if (found > 0) {
          ASSERT_NEAR(found, rate_hz, 0.05 * rate_hz) << round << " " << i;
        }
      }
      EXPECT_GT(stage.StatsOf("rig." + rig.performer).rate_hz(), 0);
      stage.Pass(20'000);
      EXPECT_EQ(stage.StatsOf("rig." + rig.performer).rate_hz(), 0);
      rig.time_ns += 20'000 * kMs_u;
    }
  }
}

TEST_F(HostileSenderTest, ARigOf3HzIsNotFlaggedAsIfItLostFrames) {
  Rig slow("slow", 3);
  slow.period_ns = 333 * kMs_u;
  Deliver({slow.Body()});
  for (int i = 0; i < 30; ++i) {
    stage.Pass(333);
    Deliver({slow.Frame()});
  }
  EXPECT_LE(stage.Count(Counter::kStylistConcealed), 1U);
}

TEST_F(HostileSenderTest, BodiesWithoutFramesHoldNoPlace) {
  for (int k = 0; k < 64; ++k) {
    Rig rig("ghost" + std::to_string(k), 100 + static_cast<std::uint64_t>(k));
    Deliver({rig.Body()});
  }
  Rig real("real", 5);
  Deliver({real.Body(), real.Frame()});
  EXPECT_EQ(Left("rig.real"), 0U) << "they may be about to begin";
  stage.Pass(5000);
  Deliver({real.Body(), real.Frame()});
  EXPECT_EQ(Left("rig.real"), 1U);
}

// The first frame of a replaced performer stands behind the newcomer's body in one batch.
TEST_F(HostileSenderTest, APerformerReplacedWithinABatchIsNotTouchedAgain) {
  std::vector<Rig> ghosts;
  for (int k = 0; k < 64; ++k) {
    ghosts.emplace_back("ghost" + std::to_string(k), 100 + static_cast<std::uint64_t>(k));
    Deliver({ghosts.back().Body()});
  }
  stage.Pass(5000);
  Rig real("real", 5);
  Deliver({real.Body(), ghosts[0].Frame(), real.Frame(), ghosts[1].Frame()});
  EXPECT_EQ(Left("rig.real"), 1U);
  EXPECT_EQ(Left("rig.ghost0"), 0U);
  EXPECT_EQ(Left("rig.ghost1"), 1U);
  EXPECT_EQ(stage.Count(Counter::kPipelineBeforeBody), 1U) << "ghost0's";
}

TEST_F(HostileSenderTest, ARigOf1HzGetsItsStyle) {
  v1::Request request;
  request.set_performer("*");
  auto& mix = *request.mutable_set()->add_mix();
  mix.set_style("style1");
  mix.set_weight(1);
  request.mutable_set()->set_transition_ms(0);
  ASSERT_EQ(stage.Ask(request).code(), v1::CODE_OK);
  Rig slow("slow", 3);
  slow.period_ns = 1'000'000'000;
  Deliver({slow.Body()});
  for (int s = 0; s < 20; ++s) {
    stage.Pass(1000);
    Deliver({slow.Frame()});
  }
  std::size_t turned = 0;
  const v1::SourceFrame source = slow.MakeFrame();
  for (const v1::Frame& frame : stage.publisher.frames) {
    float apart = 0;
    if (frame.output() != v1::OUTPUT_CANONICAL || frame.sequence() < 10) continue;
    for (int i = 0; i < frame.rotations_size(); ++i) {
      apart = std::max(apart, std::abs(frame.rotations(i) - source.rotations(i)));
    }
    turned += apart > 0.02F ? 1 : 0;
  }
  EXPECT_GE(turned, 10U);
}

TEST_F(HostileSenderTest, EveryPerformersRefusedBodyIsReported) {
  for (int round = 0; round < 5; ++round) {
    for (int k = 0; k < 5; ++k) {
      Rig rig("p" + std::to_string(k), 50 + static_cast<std::uint64_t>(k));
      v1::Body body = rig.MakeBody();
      body.set_dialect("nonsense");
      Deliver({rig.Datagram(native::Kind::kBody, body.SerializeAsString())});
    }
    stage.Pass(100);
  }
  const auto lines = stage.Lines();
  EXPECT_EQ(lines.size(), 5U);
  for (int k = 0; k < 5; ++k) {
    const std::string begin = "rig.p" + std::to_string(k) + ": ";
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.starts_with(begin);
    })) << begin;
  }
}

TEST_F(HostileSenderTest, AChangingBodyDoesNotFillTheLog) {
  Rig rig("a", 5);
  for (int i = 0; i < 950; ++i) {
    v1::Body body = rig.MakeBody();
    body.set_offsets(3, 0.001F * static_cast<float>(i % 2));
    Deliver({rig.Datagram(native::Kind::kBody, body.SerializeAsString())});
    stage.clock.now_ns += static_cast<std::int64_t>(kMs_u);
  }
  EXPECT_LE(stage.Lines().size(), 3U);
  EXPECT_GE(stage.Count(Counter::kPipelineEventsHeldBack), 400U);
  EXPECT_LE(stage.Count(Counter::kPipelineBodyChanges), 8U + 2) << "each makes all anew";
}

// A skeleton whose left and right are exchanged, by its rests: the toes point backwards.
v1::Body WithRests(v1::Body body) {
  body.set_dialect("");
  for (int j = 0; j < body.names_size(); ++j) {
    for (const float value : {0.0F, 0.0F, 0.0F, 1.0F}) body.add_rest(value);
  }
  return body;
}

TEST_F(HostileSenderTest, ExchangedSidesAreReportedLoggedAndFlagged) {
  Rig rig("a", 5);
  v1::Body body = WithRests(rig.MakeBody());
  Deliver({rig.Datagram(native::Kind::kBody, body.SerializeAsString()), rig.Frame()});
  EXPECT_EQ(stage.publisher.frames.back().flags() & v1::FLAG_BACKWARDS, 0U);
  EXPECT_EQ(stage.StatsOf("rig.a").warning(), "");
  (void)stage.Lines();
  for (std::string& name : *body.mutable_names()) {
    if (name.starts_with("left")) {
      name = "right" + name.substr(4);
    } else if (name.starts_with("right")) {
      name = "left" + name.substr(5);
    }
  }
  Deliver({rig.Datagram(native::Kind::kBody, body.SerializeAsString()), rig.Frame()});
  EXPECT_EQ(stage.publisher.frames.back().flags() & v1::FLAG_BACKWARDS, v1::FLAG_BACKWARDS);
  EXPECT_NE(stage.StatsOf("rig.a").warning().find("left and right"), std::string::npos);
  const auto lines = stage.Lines();
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
    return line.find("toes point backwards") != std::string::npos;
  }));
}

TEST_F(HostileSenderTest, MirroredAxesAreReportedLoggedAndFlagged) {
  Rig rig("a", 5);
  v1::Body body = WithRests(rig.MakeBody());
  for (int j = 0; j < body.names_size(); ++j) body.set_offsets(3 * j, -body.offsets(3 * j));
  Deliver({rig.Datagram(native::Kind::kBody, body.SerializeAsString()), rig.Frame()});
  EXPECT_EQ(stage.publisher.frames.back().flags() & v1::FLAG_BACKWARDS, v1::FLAG_BACKWARDS);
}

TEST_F(HostileSenderTest, APerformerWhoWalksAgainstTheToesIsFlaggedAfterAWhile) {
  Rig rig("a", 5);
  Deliver({rig.Body()});
  float z_m = 0;
  const auto walk = [&](float speed_mps, int frames) {
    for (int i = 0; i < frames; ++i) {
      stage.clock.now_ns += static_cast<std::int64_t>(rig.period_ns);
      z_m += speed_mps / 120;
      Deliver({rig.Frame([z_m](v1::SourceFrame& frame) { frame.set_root_position(2, z_m); })});
    }
  };
  walk(1.2F, 1200);
  EXPECT_EQ(stage.Count(Counter::kPipelineBackwards), 0U);
  walk(-1.2F, 6000);
  EXPECT_GT(stage.Count(Counter::kPipelineBackwards), 1000U);
  EXPECT_NE(stage.StatsOf("rig.a").warning().find("against where the toes"), std::string::npos);
  const auto lines = stage.Lines();
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                          [](const std::string& line) {
                            return line.find("against where the toes") != std::string::npos;
                          }),
            1);
}

}  // namespace
}  // namespace styled::pipeline
