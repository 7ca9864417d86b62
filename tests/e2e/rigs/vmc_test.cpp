#include "sim/rigs/vmc.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/daemon.h"
#include "tests/support/rig.h"
#include "tests/support/rig_run.h"
#include "tests/unit/vmc/bytes.h"

namespace styled::support {
namespace {

RigRun Vmc(std::vector<std::string> quirks) {
  RigRun run;
  run.type = "vmc";
  run.quirks = std::move(quirks);
  run.expected_performer = "suit.suit";
  return run;
}

TEST(VmcRigTest, PosesOfTheApplicationAreTheMotionInCanonicalAxes) {
  const RigResult result = StreamAsRig(Vmc({}));
  ExpectTheSameMotion(result);
  ASSERT_FALSE(result.bodies.empty());
  EXPECT_EQ(result.bodies[0].names_size(), 21) << "the rig's own skeleton is published, too";
  EXPECT_EQ(result.bodies[0].names(0), "Hips");
}

TEST(VmcRigTest, WithTFirstInOneBundleOrInNestedOnes) {
  ExpectTheSameMotion(StreamAsRig(Vmc({"t-first"})));
  ExpectTheSameMotion(StreamAsRig(Vmc({"nested", "moving-root"})));
}

TEST(VmcRigTest, InSingleMessagesWithFingersAndFace) {
  RigRun run = Vmc({"single", "full"});
  run.keys = "performer = \"anna\"";
  run.expected_performer = "suit.anna";
  const RigResult result = StreamAsRig(run);
  ExpectTheSameMotion(result);
  ASSERT_FALSE(result.bodies.empty());
  EXPECT_EQ(result.bodies[0].names_size(), 55);
}

TEST(VmcRigTest, WithoutOffsets) { ExpectTheSameMotion(StreamAsRig(Vmc({"zero-offsets"}))); }

TEST(VmcRigTest, FaultsAreCountedAndTheRestComesThrough) {
  RigRun run = Vmc({});
  run.frames = 300;
  run.faults = "loss=0.03,duplicate=0.02,truncate=0.02,nan=0.02,reorder=0.02,seed=3";
  const RigResult result = StreamAsRig(run);
  EXPECT_GT(result.Counter("source.malformed"), 0U);
  EXPECT_GT(result.Counter("source.incomplete"), 0U);
  EXPECT_GT(result.Counter("pipeline.duplicate"), 0U);
  EXPECT_GT(result.Counter("pipeline.reordered"), 0U);
  EXPECT_GT(result.Counter("stylist.held"), 0U);
  EXPECT_EQ(result.Counter("pipeline.sessions"), 1U);
  EXPECT_GT(result.received, 240);
  for (const auto& frame : result.frames) {
    for (const float value : frame.rotations()) ASSERT_TRUE(std::isfinite(value));
  }
}

TEST(VmcRigTest, ARestartIsANewSessionOfTheSamePerformer) {
  RigRun run = Vmc({"t-first"});
  run.frames = 400;
  run.faults = "restart=0.01,restart-pause-ms=300,seed=5";
  const RigResult result = StreamAsRig(run);
  EXPECT_GT(result.Counter("pipeline.sessions"), 1U);
  EXPECT_EQ(result.Counter("pipeline.performers"), 1U);
  EXPECT_GT(result.received, result.sent / 2);
}

TEST(VmcRigTest, TheSecondSenderOnAPortIsRefusedWhileTheFirstIsLive) {
  Daemon daemon({}, "[[source]]\nname = \"suit\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n");
  const UdpLink first(daemon.listens.at(2)), second(daemon.listens.at(2));
  Subscriber subscriber(daemon.publish, {""});
  ASSERT_TRUE(subscriber.WaitFor([&] { return subscriber.LastStats().has_value(); }, 10));
  rigs::Options options;
  auto rig = rigs::MakeVmc(options);
  options.quirks = {"t-first"};
  auto other = rigs::MakeVmc(options);
  body::Pose pose, elsewhere;
  elsewhere.hips_position_m.x() = 5;
  const auto send = [](rigs::Rig& from, int i, const body::Pose& as, const UdpLink& link) {
    from.Encode({static_cast<std::uint64_t>(i), i / 60.0, {&as, 1}},
                [&link](std::span<const std::byte> bytes) {
                  link.Send(Bytes(bytes.begin(), bytes.end()));
                });
  };
  Paced(120, 60, [&](int i) {
    send(*rig.value(), i, pose, first);
    if (i > 30) send(*other.value(), i, elsewhere, second);
  });
  const std::string topic = "styled/suit.suit/canonical/";
  ASSERT_TRUE(subscriber.WaitFor([&] { return subscriber.Frames(topic).size() >= 118; }, 10));
  for (const auto& frame : subscriber.Frames(topic)) {
    EXPECT_NEAR(frame.root_position(0), 0, 0.01F);
  }
  ControlClient control(daemon.control);
  EXPECT_GT(control.Counter("pipeline.second_sender"), 50U);
}

// For ten seconds, an application that tracks no legs.
TEST(VmcRigTest, ASenderOfHandsAndHeadIsOneRefusedRowAndItsReasonIsLoggedOnce) {
  Daemon daemon({}, "[[source]]\nname = \"suit\"\ntype = \"vmc\"\nlisten = \"127.0.0.1:0\"\n");
  const UdpLink link(daemon.listens.at(2));
  ControlClient control(daemon.control);
  const std::string reason =
      "VMC sends no leg bones: found Head, LeftHand, RightHand, missing Hips";
  Paced(600, 60, [&](int i) {
    std::vector<vmc::testing::Bytes> messages{
        vmc::testing::TimeMessage(static_cast<float>(i) / 60)};
    for (const char* bone : {"Head", "LeftHand", "RightHand"}) {
      messages.push_back(vmc::testing::BoneMessage(bone, 0.1F));
    }
    link.Send(vmc::testing::Bundle(messages));
    if (i < 180 || i % 45 != 0) return;
    const auto status = control.Status();
    ASSERT_EQ(status.stats().performers_size(), 1);
    const v1::PerformerStats& row = status.stats().performers(0);
    EXPECT_EQ(row.performer(), "suit.suit");
    EXPECT_EQ(row.refused_as(), "pipeline.bodies_refused");
    EXPECT_FALSE(row.live());
    EXPECT_EQ(row.warning().find(reason), 0U) << row.warning();
  });
  EXPECT_EQ(control.Counter("pipeline.frames"), 0U);
  const std::string log = daemon.Log();
  const std::size_t at = log.find("suit.suit: " + reason);
  ASSERT_NE(at, std::string::npos) << log;
  EXPECT_EQ(log.find("leg bones", at + reason.size()), std::string::npos) << log;
  // Another application sends a whole body: it is the performer, whatever the first one sends.
  const UdpLink other(daemon.listens.at(2));
  auto rig = rigs::MakeVmc({});
  const body::Pose pose;
  Paced(120, 60, [&](int i) {
    link.Send(vmc::testing::Bundle({vmc::testing::TimeMessage(11 + static_cast<float>(i) / 60),
                                    vmc::testing::BoneMessage("Head", 0.1F)}));
    rig.value()->Encode(
        {static_cast<std::uint64_t>(i), i / 60.0, {&pose, 1}},
        [&](std::span<const std::byte> bytes) { other.Send(Bytes(bytes.begin(), bytes.end())); });
  });
  const v1::PerformerStats row = control.Performer("suit.suit");
  EXPECT_TRUE(row.live());
  EXPECT_EQ(row.warning(), "");
  EXPECT_GT(row.published(), 100U);
}

}  // namespace
}  // namespace styled::support
