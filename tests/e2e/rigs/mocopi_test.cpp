#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/rig_run.h"

namespace styled::support {
namespace {

TEST(MocopiRigTest, PosesAreTheMotionInCanonicalAxes) {
  const RigResult result = StreamAsRig({.type = "mocopi", .expected_performer = "suit.suit"});
  ExpectTheSameMotion(result);
  ASSERT_FALSE(result.bodies.empty());
  EXPECT_EQ(result.bodies[0].names_size(), 27) << "the rig's own skeleton is published, too";
}

TEST(MocopiRigTest, WithTimecodeFromAnEarlyAppAndCalledAsTheConfigSays) {
  ExpectTheSameMotion(StreamAsRig({.type = "mocopi",
                                   .quirks = {"tmcd"},
                                   .keys = "performer = \"anna\"",
                                   .expected_performer = "suit.anna"}));
  ExpectTheSameMotion(
      StreamAsRig({.type = "mocopi", .quirks = {"early"}, .expected_performer = "suit.suit"}));
}

TEST(MocopiRigTest, FaultsAreCountedAndTheRestComesThrough) {
  const RigResult result = StreamAsRig(
      {.type = "mocopi",
       .expected_performer = "suit.suit",
       .frames = 300,
       .faults = "loss=0.03,duplicate=0.02,truncate=0.02,nan=0.02,reorder=0.02,seed=3"});
  EXPECT_GT(result.Counter("source.malformed"), 0U);
  EXPECT_GT(result.Counter("pipeline.lost"), 0U);
  EXPECT_GT(result.Counter("pipeline.duplicate"), 0U);
  EXPECT_GT(result.Counter("pipeline.reordered"), 0U);
  EXPECT_GT(result.Counter("stylist.held"), 0U);
  EXPECT_GT(result.received, 240);
  for (const auto& frame : result.frames) {
    for (const float value : frame.rotations()) ASSERT_TRUE(std::isfinite(value));
  }
}

TEST(MocopiRigTest, ARestartIsANewSessionOfTheSamePerformer) {
  const RigResult result = StreamAsRig({.type = "mocopi",
                                        .expected_performer = "suit.suit",
                                        .frames = 400,
                                        .faults = "restart=0.01,seed=5"});
  EXPECT_GT(result.Counter("pipeline.sessions"), 1U);
  EXPECT_EQ(result.Counter("pipeline.performers"), 1U);
  EXPECT_GT(result.received, result.sent / 2);
}

}  // namespace
}  // namespace styled::support
