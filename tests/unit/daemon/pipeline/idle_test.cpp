// Bodies that move by themselves (v1::Look.idle), with their rigs and while those are silent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "daemon/pipeline/pipeline.h"
#include "model/body/pose.h"
#include "tests/support/fake_pipeline.h"
#include "tests/support/native_frames.h"
#include "tests/support/rig.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;

constexpr float kDegree = 57.29578F;

struct Seen {
  body::Pose pose;
  std::uint32_t flags = 0;
};

// A performer at 120 Hz on the canonical body, and their published canonical poses.
class IdleStage {
 public:
  explicit IdleStage(float idle, std::string style = "")
      : pipeline(
            [&] {
              auto config = std::make_shared<RuntimeConfig>();
              config->network = erd::RandomStylizer(5, 1);
              config->style.initial = std::move(style);
              config->performers = {};
              config->idle = {idle};
              return config;
            }(),
            "styled/rig.a/canonical/") {
    pipeline.Deliver({rig.Body()});
  }

  void Send(const std::function<void(v1::SourceFrame&)>& change = [](v1::SourceFrame&) {}) {
    Advance(static_cast<std::int64_t>(rig.period_ns));
    pipeline.Deliver({rig.Frame(change)});
  }
  // The rig sends nothing for these seconds; its clock continues unless it `pauses`.
  void Silence(double seconds, bool pauses = false) {
    constexpr std::int64_t kTurn_ns = 4'000'000;
    const auto turns = static_cast<int>(seconds * 1e9 / kTurn_ns);
    for (int i = 0; i < turns; ++i) Advance(kTurn_ns);
    if (!pauses) rig.time_ns += static_cast<std::uint64_t>(turns * kTurn_ns);
  }
  // The frames since the last call.
  std::vector<Seen> Frames() {
    std::vector<Seen> seen;
    for (const v1::Frame& frame : pipeline.publisher.frames) {
      Seen& one = seen.emplace_back();
      one.flags = frame.flags();
      std::memcpy(one.pose.hips_position_m.data(), frame.root_position().data(), 3 * sizeof(float));
      for (std::size_t j = 0; j < body::kJointCount; ++j) {
        std::memcpy(one.pose.rotations[j].coeffs().data(),
                    frame.rotations().data() + 4 * static_cast<int>(j), 4 * sizeof(float));
      }
    }
    pipeline.publisher.frames.clear();
    return seen;
  }
  void SetIdle(float idle) {
    v1::Request request;
    request.set_performer("rig.a");
    request.mutable_set()->set_idle(idle);
    const v1::Reply reply = pipeline.Ask(request);
    EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  }

  support::Rig rig{"a"};
  support::FakePipeline pipeline;

 private:
  void Advance(std::int64_t ns) {
    pipeline.clock.now_ns += ns;
    pipeline.Work();
  }
};

// The largest step of a joint or of the hips from one frame to the next.
struct Step {
  float deg = 0, m = 0;
};
Step Largest(const std::vector<Seen>& frames) {
  Step step;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto &a = frames[i - 1].pose, &b = frames[i].pose;
    step.m = std::max(step.m, (a.hips_position_m - b.hips_position_m).norm());
    for (std::size_t j = 0; j < body::kJointCount; ++j) {
      step.deg = std::max(step.deg,
                          kDegree * body::Log(a.rotations[j].conjugate() * b.rotations[j]).norm());
    }
  }
  return step;
}

// A pose far from the rig's own: turned around, elsewhere, arms up.
void Elsewhere(v1::SourceFrame& frame) {
  (*frame.mutable_root_position())[0] += 1;
  const auto set = [&](int joint, const body::Quat& q) {
    for (int k = 0; k < 4; ++k) frame.set_rotations(4 * joint + k, q.coeffs()[k]);
  };
  set(body::kHips, body::Exp({0, 1.5F, 0}));
  set(body::kLeftUpperArm, body::Exp({0, 0, 1.2F}));
  set(body::kRightUpperArm, body::Exp({0, 0, -1.2F}));
}

TEST(IdleTest, WithoutItAFrameIsTheRigsBitForBit) {
  IdleStage off(0), on(1);
  for (int i = 0; i < 120; ++i) {
    off.Send();
    on.Send();
  }
  v1::SourceFrame sent;
  off.Send([&](v1::SourceFrame& frame) { sent = frame; });
  on.Send();
  const Seen with = on.Frames().back(), without = off.Frames().back();
  float most_deg = 0;
  for (std::size_t j = 0; j < body::kJointCount; ++j) {
    const float* const given = sent.rotations().data() + 4 * j;
    // Up to the sign, which the canonical body has with w >= 0.
    const body::Quat q(given[3], given[0], given[1], given[2]);
    EXPECT_EQ(std::abs(q.dot(without.pose.rotations[j])), q.squaredNorm()) << j;
    most_deg = std::max(
        most_deg,
        kDegree * body::Log(with.pose.rotations[j].conjugate() * without.pose.rotations[j]).norm());
  }
  EXPECT_GT(most_deg, 0.3F) << "with it, the body breathes";
  EXPECT_LT(most_deg, 8) << "knees that were straight bend most";
  // Switched off, the motion fades without a jump, and is gone.
  on.SetIdle(0);
  for (int i = 0; i < 6 * 120; ++i) on.Send();
  off.SetIdle(0);
  for (int i = 0; i < 6 * 120; ++i) off.Send();
  const auto faded = on.Frames(), never = off.Frames();
  EXPECT_LT(Largest(faded).deg, Largest(never).deg + 0.1F);
  EXPECT_EQ(std::memcmp(&faded.back().pose, &never.back().pose, sizeof(body::Pose)), 0);
}

TEST(IdleTest, AMinuteOfSilenceShowsNoFrozenPoseAndNoJumpAtTheReturn) {
  for (const bool styled : {false, true}) {
    for (const int how : {0, 1, 2}) {  // the rig's clock continued, paused, or the rig restarted
      SCOPED_TRACE(std::to_string(how) + (styled ? " styled" : " bypass"));
      IdleStage stage(1, styled ? "style1" : "");
      for (int i = 0; i < 240; ++i) stage.Send();
      const Step usual = Largest(stage.Frames());
      stage.Silence(65, how == 1);
      const auto silent = stage.Frames();
      // At 120 Hz, after a quarter of a second in which the rig may still come.
      EXPECT_GT(silent.size(), 64U * 110);
      EXPECT_LT(silent.size(), 64U * 126);
      for (const Seen& frame : silent) ASSERT_NE(frame.flags & v1::FLAG_STALE, 0U);
      const float moved_deg = Largest({silent[0], silent[240]}).deg;
      EXPECT_GT(moved_deg, 0.2F) << "2 s later";
      EXPECT_LT(Largest(silent).deg, 1) << "nothing jumps";
      if (how == 2) {
        stage.rig = support::Rig("a", 99);
        stage.pipeline.Deliver({stage.rig.Body()});
      }
      for (int i = 0; i < 240; ++i) stage.Send(Elsewhere);
      auto returned = stage.Frames();
      EXPECT_EQ(std::ranges::count_if(
                    returned, [](const Seen& seen) { return (seen.flags & v1::FLAG_STALE) == 0; }),
                240);
      EXPECT_EQ(returned.back().flags & v1::FLAG_STALE, 0U);
      returned.insert(returned.begin(), silent.back());
      // 110 degrees in half a second, smoothly: 330 degrees a second at most.
      EXPECT_LT(Largest(returned).deg, usual.deg + 4);
      EXPECT_LT(Largest(returned).m, usual.m + 0.03F);
      EXPECT_NEAR(returned.back().pose.hips_position_m.x(), 1, styled ? 0.3F : 0.03F);
    }
  }
}

TEST(IdleTest, WithoutItSilenceIsOneStaleFrame) {
  IdleStage stage(0);
  for (int i = 0; i < 10; ++i) stage.Send();
  (void)stage.Frames();
  stage.Silence(10);
  EXPECT_EQ(stage.Frames().size(), 1U);
  EXPECT_EQ(stage.pipeline.Count(Counter::kPipelineIdle), 0U);
}

TEST(IdleTest, ItCanBeSwitchedOnInTheSilence) {
  IdleStage stage(0);
  for (int i = 0; i < 10; ++i) stage.Send();
  stage.Silence(5);
  auto frames = stage.Frames();
  frames.erase(frames.begin(), frames.end() - 1);
  stage.SetIdle(1);
  stage.Silence(4);
  const auto moving = stage.Frames();
  EXPECT_GT(moving.size(), 400U);
  frames.insert(frames.end(), moving.begin(), moving.end());
  // The straight knees of this rig are the worst case: they begin to bend by 1.2 degrees.
  EXPECT_LT(Largest(frames).deg, 2) << "it begins from the pose that stood still";
  EXPECT_GT(Largest({moving[0], moving[300]}).deg, 0.2F);
}

TEST(IdleTest, ItCanBeSwitchedOffInTheSilence) {
  IdleStage stage(1);
  for (int i = 0; i < 10; ++i) stage.Send();
  stage.Silence(2);
  EXPECT_GT(stage.Frames().size(), 100U);
  stage.SetIdle(0);
  stage.Silence(2);
  EXPECT_EQ(stage.Frames().size(), 0U);
  stage.Silence(60);
  EXPECT_EQ(stage.pipeline.Count(Counter::kPipelinePerformers), 0U) << "forgotten as any other";
}

TEST(IdleTest, TheNeutralIsNotLearnedFromIt) {
  IdleStage stage(1);
  for (int i = 0; i < 240; ++i) stage.Send();
  const float before = stage.pipeline.StatsOf("rig.a").neutral().body_s();
  stage.Silence(30);
  EXPECT_EQ(stage.pipeline.StatsOf("rig.a").neutral().body_s(), before);
}

float ValueOf(const v1::Frame& frame, const std::string& name) {
  for (const auto& expression : frame.expressions()) {
    if (expression.name() == name) return expression.value();
  }
  return -1;
}

TEST(IdleTest, AFaceThatWasOnlyThisPerformersRelaxesAndBlinks) {
  IdleStage stage(1);
  for (int i = 0; i < 30; ++i) {
    stage.Send([](v1::SourceFrame& frame) {
      for (const auto& [name, value] : {std::pair{"jawOpen", 0.8F}, {"eyeBlinkLeft", 0.0F}}) {
        auto& expression = *frame.add_expressions();
        expression.set_name(name);
        expression.set_value(value);
      }
    });
  }
  EXPECT_EQ(ValueOf(stage.pipeline.publisher.frames.back(), "jawOpen"), 0.8F);
  stage.pipeline.publisher.frames.clear();
  stage.Silence(30);
  float blink = 0;
  int blinks = 0;
  for (const v1::Frame& frame : stage.pipeline.publisher.frames) {
    const float now = ValueOf(frame, "eyeBlinkLeft");
    blinks += now > 0.5F && blink <= 0.5F ? 1 : 0;
    blink = now;
  }
  EXPECT_GE(blinks, 5);
  EXPECT_LE(blinks, 12);
  EXPECT_LT(ValueOf(stage.pipeline.publisher.frames.back(), "jawOpen"), 0.01F);
  stage.Send();
  EXPECT_EQ(stage.pipeline.publisher.frames.back().expressions_size(), 0) << "as the rig sends it";
}

// A standby performs the silence that its leader decided, with the same bits.
TEST(IdleTest, AFollowerShowsTheSameMotion) {
  IdleStage leader(1), follower(1);
  for (int i = 0; i < 60; ++i) {
    leader.Send();
    follower.Send();
  }
  leader.Silence(0.252);
  const auto led = leader.Frames();
  ASSERT_NE(led.back().flags & v1::FLAG_STALE, 0U);
  const v1::Frame& last = follower.pipeline.publisher.frames.back();
  v1::Silence silence;
  v1::Applied& stale = *silence.add_stale();
  stale.set_performer("rig.a");
  stale.set_first_sequence(last.sequence() + 1);
  v1::IdleFrame& idle = *silence.add_idle();
  idle.set_performer("rig.a");
  idle.set_published(last.sequence() + 2);
  idle.set_elapsed_ns(59 * static_cast<std::int64_t>(follower.rig.period_ns) + 252'000'000);
  follower.pipeline.pipeline().OnSilence(silence);
  const auto followed = follower.Frames();
  ASSERT_EQ(followed.size(), led.size());
  EXPECT_EQ(std::memcmp(&followed.back().pose, &led.back().pose, sizeof(body::Pose)), 0);
}

// A standby that joins in the silence has the pose by a checkpoint alone.
TEST(IdleTest, ItContinuesFromACheckpointThatWasTakenInTheSilence) {
  IdleStage leader(1), other(1);
  for (int i = 0; i < 60; ++i) leader.Send(Elsewhere);
  leader.Silence(3);
  v1::Request take;
  take.set_performer("rig.a");
  take.mutable_take_checkpoint();
  const v1::Reply taken = leader.pipeline.Ask(take);
  ASSERT_EQ(taken.code(), v1::CODE_OK) << taken.reason();
  const body::Pose last = leader.Frames().back().pose;
  v1::Request restore;
  *restore.mutable_restore_checkpoint()->mutable_checkpoint() = taken.checkpoint();
  ASSERT_EQ(other.pipeline.Ask(restore).code(), v1::CODE_OK);
  other.Silence(1);
  const auto frames = other.Frames();
  ASSERT_GT(frames.size(), 20U);
  EXPECT_LT(Largest({{last, 0}, frames.front()}).deg, 1);
  EXPECT_LT(Largest({{last, 0}, frames.front()}).m, 0.01F);
}

// 40 rigs stop at once beside one that sends: each turn sends few of their frames, and all of them
// move.
TEST(IdleTest, ManySilentPerformersLeaveTimeForTheOthers) {
  IdleStage stage(1);
  std::vector<support::Rig> rigs;
  for (int i = 0; i < 40; ++i) {
    rigs.emplace_back("p" + std::to_string(i), 100 + i);
    stage.pipeline.Deliver({rigs.back().Body(), rigs.back().Frame()});
  }
  stage.pipeline.publisher.events.push_back({true, "styled/rig.p"});
  stage.Silence(1);
  stage.pipeline.publisher.frames.clear();
  const std::uint64_t before = stage.pipeline.Count(Counter::kPipelineIdle);
  std::uint64_t most = 0;
  for (int i = 0; i < 250; ++i) {
    const std::uint64_t at = stage.pipeline.Count(Counter::kPipelineIdle);
    stage.pipeline.clock.now_ns += 4'000'000;
    (void)stage.pipeline.pipeline().DoWork();
    most = std::max(most, stage.pipeline.Count(Counter::kPipelineIdle) - at);
  }
  EXPECT_LE(most, 8U);
  std::map<std::string, int> of;
  for (const v1::Frame& frame : stage.pipeline.publisher.frames) ++of[frame.performer()];
  EXPECT_EQ(of.size(), 40U);
  for (const auto& [performer, frames] : of) EXPECT_GE(frames, 15) << performer;
  EXPECT_LE(stage.pipeline.Count(Counter::kPipelineIdle) - before, 250U * 8);
}

TEST(IdleTest, ItLeavesItsPlaceWhereAllAreTaken) {
  IdleStage stage(1);
  auto config = std::make_shared<RuntimeConfig>();
  config->network = erd::RandomStylizer(5, 1);
  config->performers.max_performers = 1;
  config->idle = {1};
  support::FakePipeline full(config, "styled/");
  support::Rig rig("a"), other("b", 8);
  full.Deliver({rig.Body(), rig.Frame()});
  full.Pass(30'000);
  full.Deliver({other.Body()});
  EXPECT_EQ(full.Count(Counter::kPipelinePerformersRefused), 1U);
  full.Pass(31'000);
  full.Deliver({other.Body(), other.Frame()});
  EXPECT_EQ(full.StatsOf("rig.b").performer(), "rig.b");
}

// A style that was set before the phone came does not stop their breath.
TEST(IdleTest, APreparedPerformerHasIt) {
  IdleStage stage(1, "");
  v1::Request request;
  request.set_performer("rig.b");
  request.mutable_set()->set_strength(0.5F);
  ASSERT_EQ(stage.pipeline.Ask(request).code(), v1::CODE_OK);
  support::Rig other("b", 9);
  stage.pipeline.Deliver({other.Body(), other.Frame()});
  EXPECT_EQ(stage.pipeline.StatsOf("rig.b").look().idle(), 1);
}

TEST(IdleTest, APerformerWhoWasHereKeepsTheirs) {
  IdleStage stage(1);
  stage.Send();
  EXPECT_EQ(stage.pipeline.StatsOf("rig.a").look().idle(), 1);
  stage.SetIdle(0);
  stage.Silence(61);
  EXPECT_EQ(stage.pipeline.Count(Counter::kPipelinePerformers), 0U);
  stage.pipeline.Deliver({stage.rig.Body(), stage.rig.Frame()});
  EXPECT_EQ(stage.pipeline.StatsOf("rig.a").look().idle(), 0);
}

}  // namespace
}  // namespace styled::pipeline
