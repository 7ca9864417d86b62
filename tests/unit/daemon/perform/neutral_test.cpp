// The performer's neutral in the daemon: told, calibrated, kept, forgotten.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/looks/state_file.h"
#include "model/net/weights_file.h"
#include "tests/support/fake_pipeline.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::pipeline {
namespace {

using support::FakePipeline;
using testing::HasSubstr;

std::shared_ptr<RuntimeConfig> MakeConfig(bool knows_reference) {
  auto config = std::make_shared<RuntimeConfig>();
  erd::WeightsFile weights = erd::RandomWeights(3, 1);
  if (knows_reference) {
    neutral::Reference reference;
    reference.walking.rotations[body::kSpine] = body::Exp(body::Vec3(0.2F, 0, 0));
    reference.standing = reference.running = reference.walking;
    weights.metadata["version"] = net::kWeightsVersion;
    weights.metadata["reference"] = net::AsJson(reference);
  }
  config->network = erd::StylizerOf(weights);
  config->performers.forget_s = 2;
  return config;
}

class NeutralInTheDaemon : public testing::Test {
 protected:
  explicit NeutralInTheDaemon(bool knows_reference = true)
      : config_(MakeConfig(knows_reference)), pipeline_(config_, "styled/rig.a/rig/") {}

  // The rig stands, upright, for some seconds, and swings its legs: with them far apart it does not
  // stand in an ordinary way, so that 0.6 of the time counts.
  void Perform(FakePipeline& pipeline, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 120); ++i) {
      pipeline.clock.now_ns += 8'333'333;
      pipeline.Deliver({rig_.Frame()});
    }
  }
  v1::Reply Calibrate(float seconds, bool clear = false, const std::string& performer = "rig.a") {
    v1::Request request;
    request.set_performer(performer);
    request.mutable_calibrate()->set_neutral(true);
    request.mutable_calibrate()->set_seconds(seconds);
    request.mutable_calibrate()->set_clear(clear);
    return pipeline_.Ask(request);
  }
  v1::NeutralStats Told(FakePipeline& pipeline) { return pipeline.StatsOf("rig.a").neutral(); }
  // The value that would be saved last.
  std::vector<Profile> Saved() {
    std::unique_ptr<std::vector<Profile>> kept;
    std::vector<Profile> newest;
    while (pipeline_.mailboxes.profiles.Pop(kept)) newest = *kept;
    return newest;
  }

  std::shared_ptr<RuntimeConfig> config_;
  FakePipeline pipeline_;
  support::Rig rig_{"a", 9};
};

TEST_F(NeutralInTheDaemon, StatusShowsHowWellTheNeutralIsKnown) {
  pipeline_.Deliver({rig_.Body()});
  Perform(pipeline_, 0.1);
  ASSERT_TRUE(pipeline_.StatsOf("rig.a").has_neutral());
  const float first = Told(pipeline_).learned();
  Perform(pipeline_, 3);
  EXPECT_LT(first, 0.5F);
  EXPECT_GT(Told(pipeline_).learned(), 0.8F);
  EXPECT_GT(Told(pipeline_).body_s(), 1.5F);
  EXPECT_LT(Told(pipeline_).body_s(), 3.1F);
  EXPECT_FALSE(Told(pipeline_).calibrated());
}

TEST_F(NeutralInTheDaemon, ACalibrationEndsAndIsSaved) {
  pipeline_.Deliver({rig_.Body()});
  Perform(pipeline_, 1);
  const v1::Reply reply = Calibrate(2);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  ASSERT_EQ(reply.applied_size(), 1);
  (void)Saved();
  Perform(pipeline_, 1);
  EXPECT_GT(Told(pipeline_).calibrates_s(), 0.5F);
  EXPECT_FALSE(Told(pipeline_).calibrated());
  Perform(pipeline_, 2.5);
  EXPECT_TRUE(Told(pipeline_).calibrated());
  const auto saved = Saved();
  ASSERT_EQ(saved.size(), 1U);
  const auto read = ParseProfiles(FormatProfiles(saved), "state.toml");
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_TRUE(read.value().front().neutral);
  EXPECT_TRUE(read.value().front().neutral->known.calibrated);
  EXPECT_EQ(read.value().front().neutral->binding, saved.front().neutral->binding);
  // Another run of the daemon.
  FakePipeline next(config_, "styled/rig.a/rig/");
  next.pipeline().Restore(read.value());
  next.Deliver({rig_.Body()});
  Perform(next, 0.1);
  EXPECT_TRUE(Told(next).calibrated());
}

TEST_F(NeutralInTheDaemon, TheNeutralOutlivesASilence) {
  pipeline_.Deliver({rig_.Body()});
  Perform(pipeline_, 1);
  ASSERT_EQ(Calibrate(1).code(), v1::CODE_OK);
  Perform(pipeline_, 2);
  ASSERT_TRUE(Told(pipeline_).calibrated());
  for (int second = 0; second < 5; ++second) pipeline_.Pass(1000);
  ASSERT_EQ(pipeline_.Count(runtime::Counter::kPipelineForgotten), 1U);
  pipeline_.Deliver({rig_.Body()});
  Perform(pipeline_, 0.1);
  EXPECT_TRUE(Told(pipeline_).calibrated());
}

TEST_F(NeutralInTheDaemon, TheNeutralIsForgottenOnRequestAndLearnedAgain) {
  pipeline_.Deliver({rig_.Body()});
  Perform(pipeline_, 1);
  ASSERT_EQ(Calibrate(1).code(), v1::CODE_OK);
  Perform(pipeline_, 2);
  ASSERT_EQ(Calibrate(0, /*clear=*/true).code(), v1::CODE_OK);
  EXPECT_EQ(Told(pipeline_).learned(), 0);
  EXPECT_FALSE(Told(pipeline_).calibrated());
  Perform(pipeline_, 3);
  EXPECT_GT(Told(pipeline_).learned(), 0.8F);
}

// An order of rest pose by another hash is for another body.
TEST_F(NeutralInTheDaemon, ANeutralOfAnotherRestPoseIsNotUsed) {
  Profile kept;
  kept.id = "rig.a";
  kept.look = InitialLook();
  kept.neutral = KeptNeutral{.binding = 1, .known = {}};
  kept.neutral->known.body_s = 20;
  kept.neutral->known.calibrated = true;
  pipeline_.pipeline().Restore({kept});
  pipeline_.Deliver({rig_.Body()});
  Perform(pipeline_, 0.1);
  EXPECT_FALSE(Told(pipeline_).calibrated());
}

TEST_F(NeutralInTheDaemon, AnInvalidNeutralIsRefusedByName) {
  EXPECT_EQ(Calibrate(5).code(), v1::CODE_UNKNOWN_PERFORMER);
  pipeline_.Deliver({rig_.Body()});
  EXPECT_EQ(Calibrate(5).code(), v1::CODE_NOT_READY) << "no frame has come";
  Perform(pipeline_, 0.5);
  for (const float seconds : {0.5F, -1.0F, 61.0F, std::numeric_limits<float>::quiet_NaN()}) {
    const v1::Reply reply = Calibrate(seconds);
    EXPECT_EQ(reply.code(), v1::CODE_OUT_OF_RANGE) << seconds;
    EXPECT_THAT(reply.reason(), HasSubstr("expected 1 to 60"));
  }
}

struct WithoutAReference : NeutralInTheDaemon {
  WithoutAReference() : NeutralInTheDaemon(false) {}
};

TEST_F(WithoutAReference, OldWeightsHaveNoReferenceAndReportIt) {
  pipeline_.Deliver({rig_.Body()});
  Perform(pipeline_, 1);
  EXPECT_FALSE(pipeline_.StatsOf("rig.a").has_neutral());
  const v1::Reply reply = Calibrate(5);
  EXPECT_EQ(reply.code(), v1::CODE_NOT_READY);
  EXPECT_THAT(reply.reason(), HasSubstr("expected weights of version 3"));
}

}  // namespace
}  // namespace styled::pipeline
