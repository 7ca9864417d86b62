#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/rig_run.h"

namespace styled::support {
namespace {

TEST(RokokoRigTest, PosesAreTheMotionInCanonicalAxes) {
  const RigResult result = StreamAsRig({.type = "rokoko"});
  ExpectTheSameMotion(result);
  ASSERT_FALSE(result.bodies.empty());
  EXPECT_EQ(result.bodies[0].names_size(), 23) << "the rig's own skeleton is published, too";
}

TEST(RokokoRigTest, PackedWithGlovesSeveralActorsAreSeveralPerformers) {
  const RigResult result = StreamAsRig({.type = "rokoko",
                                        .quirks = {"lz4", "gloves"},
                                        .performers = {"anna", "ben", "cleo"},
                                        .frames = 90});
  ExpectTheSameMotion(result);
  EXPECT_EQ(result.Counter("pipeline.performers"), 3U);
  ASSERT_FALSE(result.bodies.empty());
  EXPECT_EQ(result.bodies[0].names_size(), 63);
}

TEST(RokokoRigTest, ANameThatIsNoneOfOursIsMadeOne) {
  ExpectTheSameMotion(StreamAsRig({.type = "rokoko",
                                   .performers = {"J\xC3\xBCrgen M."},
                                   .expected_performer = "suit.J__rgen_M_",
                                   .frames = 60}));
}

TEST(RokokoRigTest, FaultsAreCountedAndTheRestComesThrough) {
  for (const std::vector<std::string>& quirks : {std::vector<std::string>{}, {"lz4"}}) {
    const RigResult result =
        StreamAsRig({.type = "rokoko",
                     .quirks = quirks,
                     .frames = 300,
                     .faults = "loss=0.02,duplicate=0.02,truncate=0.02,nan=0.02,reorder=0.02,"
                               "corrupt=0.02,seed=3"});
    EXPECT_GT(result.Counter("source.malformed"), 0U);
    EXPECT_GT(result.Counter("pipeline.duplicate"), 0U);
    EXPECT_GT(result.Counter("pipeline.reordered"), 0U);
    EXPECT_GT(result.Counter("stylist.held"), 0U);
    EXPECT_GT(result.received, 240);
    for (const auto& frame : result.frames) {
      for (const float value : frame.rotations()) ASSERT_TRUE(std::isfinite(value));
    }
  }
}

TEST(RokokoRigTest, ARestartIsANewSessionOfTheSamePerformer) {
  const RigResult result =
      StreamAsRig({.type = "rokoko", .frames = 400, .faults = "restart=0.01,seed=5"});
  EXPECT_GT(result.Counter("pipeline.sessions"), 1U);
  EXPECT_EQ(result.Counter("pipeline.performers"), 1U);
  EXPECT_GT(result.received, result.sent / 2);
}

}  // namespace
}  // namespace styled::support
