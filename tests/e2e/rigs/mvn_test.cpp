#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/rig_run.h"

namespace styled::support {
namespace {

TEST(MvnRigTest, PosesOverUdpAreTheMotionInCanonicalAxes) {
  const RigResult result = StreamAsRig({.type = "mvn"});
  ExpectTheSameMotion(result);
  ASSERT_FALSE(result.bodies.empty());
  EXPECT_EQ(result.bodies[0].names_size(), 23) << "the rig's own skeleton is published, too";
  ASSERT_FALSE(result.rig_frames.empty());
  EXPECT_NEAR(result.rig_frames[0].root_position(2), 0.98, 0.05) << "+Z is up there";
}

TEST(MvnRigTest, OverTcpFromAnOldSenderSplitAndWithTimecode) {
  ExpectTheSameMotion(StreamAsRig({.type = "mvn-tcp", .stand_in = "mvn"}));
  ExpectTheSameMotion(StreamAsRig({.type = "mvn", .quirks = {"old", "split"}}));
  const RigResult result = StreamAsRig({.type = "mvn", .quirks = {"timecode"}});
  ExpectTheSameMotion(result);
  ASSERT_FALSE(result.frames.empty());
  EXPECT_EQ(result.frames.back().timecode().hours(), 10U);
}

TEST(MvnRigTest, SeveralCharactersAreSeveralPerformers) {
  const RigResult result =
      StreamAsRig({.type = "mvn", .performers = {"anna", "ben", "cleo"}, .frames = 60});
  ExpectTheSameMotion(result);
  EXPECT_EQ(result.Counter("pipeline.performers"), 3U);
}

TEST(MvnRigTest, FaultsAreCountedAndTheRestComesThrough) {
  const RigResult result = StreamAsRig(
      {.type = "mvn",
       .frames = 300,
       .faults = "loss=0.02,duplicate=0.02,truncate=0.02,nan=0.02,reorder=0.02,seed=3"});
  EXPECT_GT(result.Counter("source.malformed"), 0U);
  EXPECT_GT(result.Counter("pipeline.duplicate"), 0U);
  EXPECT_GT(result.Counter("pipeline.reordered"), 0U);
  EXPECT_GT(result.Counter("stylist.held"), 0U);
  EXPECT_GT(result.received, 250);
  for (const auto& frame : result.frames) {
    for (const float value : frame.rotations()) ASSERT_TRUE(std::isfinite(value));
  }
}

}  // namespace
}  // namespace styled::support
