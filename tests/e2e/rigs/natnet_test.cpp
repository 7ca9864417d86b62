#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/rig_run.h"
#include "tests/unit/natnet/multicast.h"

namespace styled::support {
namespace {

// Frames sent before server and daemon are connected.
constexpr int kHandshake = 12;

TEST(NatNetRigTest, PosesAreTheMotionInEveryBitstream) {
  ExpectTheSameMotion(StreamAsRig({.type = "natnet"}), kHandshake);
  ExpectTheSameMotion(StreamAsRig({.type = "natnet", .quirks = {"4.1"}}), kHandshake);
  ExpectTheSameMotion(StreamAsRig({.type = "natnet", .quirks = {"4.2"}}), kHandshake);
  ExpectTheSameMotion(
      StreamAsRig({.type = "natnet", .quirks = {"2.9"}, .keys = "multicast = false"}), kHandshake);
}

TEST(NatNetRigTest, ConventionsAreFoundOut) {
  const RigResult result = StreamAsRig({.type = "natnet", .quirks = {"local", "prefix"}});
  ExpectTheSameMotion(result, kHandshake);
  ASSERT_FALSE(result.bodies.empty());
  ASSERT_EQ(result.bodies[0].names_size(), 21) << "the rig's own skeleton is published, too";
  EXPECT_EQ(result.bodies[0].names(0), "Hip");
  EXPECT_EQ(result.bodies[0].names(6), "LUArm");
  ExpectTheSameMotion(StreamAsRig({.type = "natnet", .quirks = {"z-up"}}), kHandshake);
  ExpectTheSameMotion(StreamAsRig({.type = "natnet",
                                   .quirks = {"local", "z-up"},
                                   .keys = "coordinates = \"local\"\nup = \"z\""}),
                      kHandshake);
}

TEST(NatNetRigTest, SeveralSkeletonsAreSeveralPerformers) {
  const RigResult result =
      StreamAsRig({.type = "natnet", .performers = {"anna", "ben", "cleo"}, .frames = 60});
  ExpectTheSameMotion(result, kHandshake);
  EXPECT_EQ(result.Counter("pipeline.performers"), 3U);
}

TEST(NatNetRigTest, PosesComeByMulticast) {
  const std::string group = natnet::testing::OwnGroup(0);
  if (!natnet::testing::CanMulticast(group)) GTEST_SKIP() << "no multicast on loopback here";
  const RigResult result = StreamAsRig({.type = "natnet",
                                        .quirks = {"4.1", "multicast=" + group + "@127.0.0.1"},
                                        .keys = "interface = \"127.0.0.1\""});
  ExpectTheSameMotion(result, kHandshake);
}

TEST(NatNetRigTest, FaultsAreCountedAndTheRestComesThrough) {
  const RigResult result = StreamAsRig(
      {.type = "natnet",
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

TEST(NatNetRigTest, ARestartIsANewSessionOfTheSamePerformer) {
  const RigResult result =
      StreamAsRig({.type = "natnet", .frames = 400, .faults = "restart=0.01,seed=5"});
  EXPECT_GT(result.Counter("pipeline.sessions"), 1U);
  EXPECT_EQ(result.Counter("pipeline.performers"), 1U);
  EXPECT_GT(result.received, result.sent / 2);
}

}  // namespace
}  // namespace styled::support
