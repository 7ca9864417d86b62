// Each cause is made with the pipeline, and its sentence must name the cause and the cure.
#include "proto/styled/explain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/fake_pipeline.h"
#include "tests/support/units.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using support::kMs;
using testing::HasSubstr;
using testing::Not;

class ExplainTest : public testing::Test {
 protected:
  explicit ExplainTest(std::shared_ptr<const net::Stylizer> network = erd::RandomStylizer(5, 1)) {
    config_->network = std::move(network);
    config_->weights_name = "random";
  }
  support::FakePipeline& pipe() {
    if (!pipe_) pipe_.emplace(config_, "styled/");
    return *pipe_;
  }
  // A second of frames on time, with the body before them.
  void Begin() {
    pipe().Deliver({rig_.Body()});
    for (int i = 0; i < 120; ++i) Next();
  }
  void Next() { Deliver(rig_.Frame()); }
  void Deliver(const support::Bytes& datagram) {
    pipe().Pass(8);
    pipe().Deliver({datagram});
  }
  void SetStyle() {
    v1::Request request;
    request.set_performer("rig.a");
    request.mutable_set()->add_mix()->set_style("style1");
    request.mutable_set()->mutable_mix(0)->set_weight(1);
    request.mutable_set()->set_transition_ms(0);
    ASSERT_EQ(pipe().Ask(request).code(), v1::CODE_OK);
  }
  v1::Reply Ask(std::uint32_t last = 1, const std::string& performer = "rig.a") {
    v1::Request request;
    request.set_performer(performer);
    request.mutable_explain()->set_last(last);
    return pipe().Ask(request);
  }
  // Of the newest frame.
  v1::FrameFate Fate() {
    const v1::Reply reply = Ask();
    EXPECT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
    EXPECT_EQ(reply.explain().frames_size(), 1);
    return reply.explain().frames_size() == 1 ? reply.explain().frames(0) : v1::FrameFate();
  }
  std::string Text() { return Fate().text(); }

  std::shared_ptr<RuntimeConfig> config_ = std::make_shared<RuntimeConfig>();
  support::Rig rig_{"a"};
  std::optional<support::FakePipeline> pipe_;
};

TEST_F(ExplainTest, AFrameWithoutStyleNamesTheCommandThatSetsOne) {
  Begin();
  EXPECT_THAT(Text(), HasSubstr("published"));
  EXPECT_THAT(Text(), HasSubstr("No style is set: stylectl set rig.a --style NAME"));
}

TEST_F(ExplainTest, AStyledFrameThatIsWellNeedsNoSentence) {
  Begin();
  SetStyle();
  for (int i = 0; i < 60; ++i) Next();
  const v1::FrameFate fate = Fate();
  EXPECT_EQ(fate.fate(), v1::FATE_STYLED);
  EXPECT_EQ(fate.sequence(), pipe().publisher.frames.back().sequence());
  EXPECT_EQ(fate.limb_weights_size(), 5);
  EXPECT_THAT(fate.text(), Not(HasSubstr("No style")));
}

TEST_F(ExplainTest, ADuplicate) {
  Begin();
  const support::Bytes frame = rig_.Frame();
  Deliver(frame);
  Deliver(frame);
  EXPECT_THAT(Text(), HasSubstr("refused because the sequence number was received before"));
  EXPECT_THAT(Text(), HasSubstr("two senders use one session"));
}

TEST_F(ExplainTest, AReorderedFrame) {
  Begin();
  const support::Bytes early = rig_.Frame();
  Next();
  Deliver(early);
  EXPECT_THAT(Text(), HasSubstr("a newer frame has arrived already"));
  EXPECT_THAT(Text(), HasSubstr("send by cable or by TCP"));
}

TEST_F(ExplainTest, ANumberFarAhead) {
  Begin();
  rig_.sequence += 100'000;
  Next();
  EXPECT_THAT(Text(), HasSubstr("far ahead of the last one: restart the sender"));
}

TEST_F(ExplainTest, AnOldTime) {
  Begin();
  rig_.time_ns -= 10 * rig_.period_ns;
  Next();
  EXPECT_THAT(Text(), HasSubstr("the sender's time is not after that of the frame before"));
}

TEST_F(ExplainTest, ASecondSender) {
  Begin();
  support::Rig other("a", 99);
  Deliver(other.Frame());
  EXPECT_THAT(Text(), HasSubstr("another sender has this performer's name already: stop one"));
}

TEST_F(ExplainTest, AFrameOfAnotherSkeleton) {
  Begin();
  Deliver(rig_.Frame([](v1::SourceFrame& frame) { frame.set_body_crc(12345); }));
  EXPECT_THAT(Text(), HasSubstr("another skeleton is named than the one that was sent"));
}

TEST_F(ExplainTest, AFrameWithAnotherNumberOfJoints) {
  Begin();
  Deliver(rig_.Frame([](v1::SourceFrame& frame) {
    frame.mutable_rotations()->Truncate(frame.rotations_size() - 4);
  }));
  EXPECT_THAT(Text(), HasSubstr("another number of joints: let the rig"));
  EXPECT_THAT(Text(), HasSubstr("send its skeleton again"));
}

TEST_F(ExplainTest, AnUnknownRestPose) {
  // A zero pose whose bones all run sideways: no pose that anybody stands in.
  v1::Body body = rig_.MakeBody();
  body.set_dialect("auto");
  for (int joint = 1; joint < body.names_size(); ++joint) {
    if (body.offsets(3 * joint + 1) == 0) continue;
    body.set_offsets(3 * joint, std::abs(body.offsets(3 * joint + 1)));
    body.set_offsets(3 * joint + 1, 0);
  }
  pipe().Deliver({rig_.Datagram(native::Kind::kBody, body.SerializeAsString())});
  Deliver(rig_.Frame([](v1::SourceFrame& frame) { frame.set_body_crc(0); }));
  EXPECT_THAT(Text(), HasSubstr("the rig's rest pose is unknown"));
  EXPECT_THAT(Text(), HasSubstr("stylectl calibrate rig.a --pose t"));
}

TEST_F(ExplainTest, AFrameBeforeItsSkeleton) {
  Begin();
  rig_.session = 9;
  pipe().Pass(500);
  rig_.time_ns += 500 * kMs;
  Next();
  EXPECT_THAT(Text(), HasSubstr("the skeleton of its session has not arrived"));
  EXPECT_THAT(Text(), HasSubstr("A session begins with it"));
}

TEST_F(ExplainTest, ALateFrame) {
  Begin();
  pipe().Pass(40);
  Next();
  EXPECT_THAT(Text(), HasSubstr("ms behind schedule"));
  EXPECT_THAT(Text(), HasSubstr("the sender or the network paused (stylectl doctor)"));
}

TEST_F(ExplainTest, AFrameOfABacklogWasPassedOver) {
  Begin();
  std::vector<support::Bytes> pile;
  for (int i = 0; i < 24; ++i) pile.push_back(rig_.Frame());
  pipe().Pass(320);
  pipe().Deliver(pile);
  const v1::Reply reply = Ask(2);
  ASSERT_EQ(reply.explain().frames_size(), 2);
  EXPECT_THAT(reply.explain().frames(0).text(), HasSubstr("skipped"));
  EXPECT_THAT(reply.explain().frames(0).text(), HasSubstr("a newer one was waiting"));
}

TEST_F(ExplainTest, LostFramesAreCounted) {
  Begin();
  rig_.sequence += 3;
  rig_.time_ns += 3 * rig_.period_ns;
  pipe().Pass(24);
  Next();
  EXPECT_EQ(Fate().lost(), 3U);
  EXPECT_THAT(Text(), HasSubstr("3 before it were lost on the way: look at the network"));
}

TEST_F(ExplainTest, AJumpOfTheSendersClock) {
  Begin();
  rig_.time_ns += std::uint64_t{7200} * 1000 * kMs;
  Next();
  EXPECT_THAT(Text(), HasSubstr("The sender's clock jumped, so the style restarts"));
}

TEST_F(ExplainTest, JointsThatAreNotTrackedAreNamed) {
  Begin();
  Deliver(rig_.Frame([](v1::SourceFrame& frame) {
    for (int k = 0; k < 4; ++k) {
      frame.set_rotations(4 * 5 + k, std::numeric_limits<float>::quiet_NaN());
    }
  }));
  const v1::FrameFate fate = Fate();
  EXPECT_EQ(fate.held_joints(), 1U);
  EXPECT_EQ(fate.held_joint(), rig_.MakeBody().names(5));
  EXPECT_THAT(fate.text(), HasSubstr("1 joint was not tracked (" + fate.held_joint()));
  EXPECT_THAT(fate.text(), HasSubstr("lost tracker"));
}

TEST_F(ExplainTest, SilenceSendsTheLastPoseAgain) {
  Begin();
  pipe().Pass(1000);
  EXPECT_THAT(Text(), HasSubstr("fell silent, and this is a repetition of the last pose"));
}

TEST_F(ExplainTest, LimbsThatShowLittleOfTheStyleAreNamed) {
  Begin();
  SetStyle();
  // A random network reconstructs nothing.
  for (int i = 0; i < 120; ++i) Next();
  EXPECT_THAT(Text(), HasSubstr("Little of the style shows on: "));
  EXPECT_THAT(Text(), HasSubstr("arm ("));
  EXPECT_THAT(Text(), HasSubstr(" cm)"));
}

class SleepingExplainTest : public ExplainTest {
 protected:
  SleepingExplainTest() : ExplainTest(erd::StylizerOf(erd::SleepingWeights(5, 1))) {}
};

TEST_F(SleepingExplainTest, AFailedFrameNamesThePoseThatWasNotSound) {
  Begin();
  SetStyle();
  for (int i = 0; i < 10; ++i) {
    Deliver(rig_.Frame([](v1::SourceFrame& frame) {
      frame.set_root_position(1, frame.root_position(1) + 2 * erd::kAwake_m);
    }));
  }
  const v1::FrameFate fate = Fate();
  EXPECT_EQ(fate.failure(), v1::FAILURE_PREDICTION);
  EXPECT_THAT(fate.text(), HasSubstr("because the network's prediction was not sound"));
  EXPECT_THAT(fate.text(), HasSubstr("record it ([record]) and report it"));
  EXPECT_GT(pipe().Count(runtime::Counter::kStylistFailedPrediction), 0U);
}

TEST_F(ExplainTest, TheReasonForAnUnknownPerformerStatesTheCounters) {
  EXPECT_EQ(Ask(1, "rig.b").code(), v1::CODE_UNKNOWN_PERFORMER);
  EXPECT_THAT(Ask(1, "rig.b").reason(), HasSubstr("nothing arrived from any source yet"));
  pipe().Deliver({rig_.Frame()});
  EXPECT_THAT(Ask(1, "rig.a").reason(), HasSubstr("frames came without a skeleton"));
}

TEST_F(ExplainTest, TheReasonForAMistypedPerformerNamesThoseWhoAreHere) {
  Begin();
  EXPECT_EQ(Ask(1, "rig.b").code(), v1::CODE_UNKNOWN_PERFORMER);
  EXPECT_THAT(Ask(1, "rig.b").reason(),
              HasSubstr("performer \"rig.b\": no performer of this name is here; here: rig.a"));
}

TEST_F(ExplainTest, AFrameThatIsNotKeptNamesThoseThatAre) {
  Begin();
  v1::Request request;
  request.set_performer("rig.a");
  request.mutable_explain()->set_sequence(7);
  v1::Reply reply = pipe().Ask(request);
  ASSERT_EQ(reply.explain().frames_size(), 1) << reply.reason();
  EXPECT_EQ(reply.explain().frames(0).sequence(), 7U);
  request.mutable_explain()->set_sequence(100'000);
  reply = pipe().Ask(request);
  EXPECT_EQ(reply.code(), v1::CODE_OUT_OF_RANGE);
  EXPECT_THAT(reply.reason(), HasSubstr("found 100000, expected a frame that is kept: 1 to 120"));
}

TEST_F(ExplainTest, AFollowingClientGetsTheFramesSinceTheLastReply) {
  Begin();
  v1::Request request;
  request.set_performer("rig.a");
  request.mutable_explain()->set_after_ns(Ask().explain().now_ns());
  EXPECT_EQ(pipe().Ask(request).explain().frames_size(), 0);
  for (int i = 0; i < 5; ++i) Next();
  EXPECT_EQ(pipe().Ask(request).explain().frames_size(), 5);
}

TEST(ExplainTextTest, AnAvatarsFailureIsNamedWithoutTheRigsFlag) {
  v1::FrameFate fate;
  fate.set_fate(v1::FATE_STYLED);
  fate.set_sequence(3);
  fate.set_failure(v1::FAILURE_AVATAR);
  EXPECT_THAT(ExplainText(fate), HasSubstr("An avatar ([[output]]) shows the performer's own"));
  EXPECT_THAT(ExplainText(fate), HasSubstr("check the avatar's skeleton"));
}

TEST_F(ExplainTest, AThousandFramesAreKept) {
  Begin();
  for (int i = 0; i < 1200; ++i) Next();
  EXPECT_EQ(Ask(5000).explain().frames_size(), 1024);
}

}  // namespace
}  // namespace styled::pipeline
