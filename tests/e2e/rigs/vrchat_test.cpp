// Devices without bones through the daemon: VRChat's trackers, VMC's, and what stylevmc sends as
// VRChat's.
#include "sim/rigs/vrchat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "model/synthetic/performer.h"
#include "sim/player/link.h"
#include "sim/rigs/vmc_trackers.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::support {
namespace {

constexpr double kVrChatRate_hz = 100;
constexpr char kVrChatTopic[] = "styled/suit.suit/canonical/";

v1::Reply Calibrate(ControlClient& control) {
  v1::Request request;
  request.set_performer("suit.suit");
  request.mutable_calibrate()->set_sensors(v1::Calibrate::SENSORS_FULL);
  return control.Ask(request);
}

body::Pose PoseOf(const v1::Frame& frame) {
  body::Pose pose;
  const auto& p = frame.root_position();
  pose.hips_position_m = {p[0], p[1], p[2]};
  for (int j = 0; j < body::kJointCount; ++j) {
    const auto& r = frame.rotations();
    pose.rotations[static_cast<std::size_t>(j)] =
        body::Quat(r[4 * j + 3], r[4 * j], r[4 * j + 1], r[4 * j + 2]);
  }
  return pose;
}

struct VrChatStage {
  VrChatStage(const std::string& type, std::unique_ptr<rigs::Rig> made)
      : daemon({},
               "[[source]]\nname = \"suit\"\ntype = \"" + type + "\"\nlisten = \"127.0.0.1:0\"\n"),
        rig(std::move(made)),
        link(daemon.listens.at(2)),
        subscriber(daemon.publish, {""}) {
    EXPECT_TRUE(subscriber.WaitFor([&] { return subscriber.LastStats().has_value(); }, 10));
  }
  void Hold(const body::Pose& pose, double seconds) {
    Paced(static_cast<int>(seconds * kVrChatRate_hz), kVrChatRate_hz, [&](int) {
      rig->Encode({index, static_cast<double>(index) / kVrChatRate_hz, {&pose, 1}},
                  [this](std::span<const std::byte> bytes) {
                    link.Send(Bytes(bytes.begin(), bytes.end()));
                  });
      ++index;
    });
  }
  // The performer's size, of the canonical one, that the calibration found: the head's device is
  // worn some centimetres off the joint. The whole stage is scaled by it.
  float Size() {
    std::string log;
    std::size_t end = std::string::npos;
    for (int wait = 0; wait < 300 && end == std::string::npos; ++wait) {  // the reply comes first
      Sleep(0.01);
      log = daemon.Log();
      end = log.find(" of the canonical size");
    }
    return end == std::string::npos ? 0 : std::stof(log.substr(end - 4, 4));
  }
  // World rotations of the parts within 2 degrees, the hips within 3 cm.
  void ExpectFollowed(const std::vector<int>& parts) {
    synthetic::Options options;
    options.script = synthetic::ParseScript("walk:2,wave-left:2").value();
    synthetic::Performer performer(options);
    const float size = Size();
    ASSERT_NEAR(size, 1, 0.03);
    for (double time_s = 0.3; time_s < 4; time_s += 1.2) {
      body::Pose pose;
      performer.Pose(time_s, pose);
      Hold(pose, 0.5);
      const auto frames = subscriber.Frames(kVrChatTopic);
      ASSERT_FALSE(frames.empty());
      const body::Pose got = PoseOf(frames.back());
      body::WorldPose found, expected;
      body::ForwardKinematics(got, found);
      body::ForwardKinematics(pose, expected);
      for (const int part : parts) {
        const auto j = static_cast<std::size_t>(part);
        EXPECT_LT(57.29578F * expected.rotations[j].angularDistance(found.rotations[j]), 2)
            << body::kHumanoid[j].name << " at " << time_s;
      }
      EXPECT_LT((got.hips_position_m - pose.hips_position_m / size).norm(), 0.03F);
    }
  }

  Daemon daemon;
  std::unique_ptr<rigs::Rig> rig;
  UdpLink link;
  Subscriber subscriber;
  std::uint64_t index = 0;
};

TEST(VrChatRigTest, TrackersMountedAnyhowAreFollowedOnceTheyAreCalibrated) {
  VrChatStage stage(
      "vrchat",
      std::move(rigs::MakeVrChat({{"sim"}, kVrChatRate_hz, 1, {"mounted", "shuffled"}}).value()));
  stage.Hold({}, 0.5);
  ControlClient control(stage.daemon.control);
  const v1::Reply reply = Calibrate(control);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  stage.ExpectFollowed({body::kHips, body::kChest, body::kLeftFoot, body::kRightFoot,
                        body::kLeftUpperLeg, body::kRightUpperArm});
  EXPECT_EQ(control.Counter("source.malformed"), 0U);
  EXPECT_EQ(stage.daemon.Stop(), 0);
  EXPECT_NE(stage.daemon.Log().find("\"1\" on hips"), std::string::npos) << stage.daemon.Log();
}

TEST(VrChatRigTest, ATrackerThatVanishesIsHeldAndTheOthersGoOn) {
  // The head's vanishes; without one on the chest the spine leans by it.
  VrChatStage stage(
      "vrchat",
      std::move(
          rigs::MakeVrChat(
              {{"sim"}, kVrChatRate_hz, 1, {"hips", "leftFoot", "rightFoot", "head", "vanish"}})
              .value()));
  stage.Hold({}, 0.5);
  ControlClient control(stage.daemon.control);
  ASSERT_EQ(Calibrate(control).code(), v1::CODE_OK);
  stage.Hold({}, 2.4);
  EXPECT_GT(control.Counter("stylist.held"), 0U);
  const auto frames = stage.subscriber.Frames(kVrChatTopic);
  ASSERT_GT(frames.size(), 200U);
  for (const float value : frames.back().rotations()) EXPECT_TRUE(std::isfinite(value));
}

TEST(VmcTrackersRigTest, DevicesWithoutRolesAreGuessedInTheTPoseAndFollowed) {
  VrChatStage stage(
      "vmc", std::move(rigs::MakeVmcTrackers({{"sim"}, kVrChatRate_hz, 1, {"trackers"}}).value()));
  stage.Hold({}, 1);
  ControlClient control(stage.daemon.control);
  const v1::Reply reply = Calibrate(control);
  ASSERT_EQ(reply.code(), v1::CODE_OK) << reply.reason();
  stage.ExpectFollowed({body::kHips, body::kHead, body::kLeftFoot, body::kRightHand});
  EXPECT_EQ(stage.daemon.Stop(), 0);
  EXPECT_NE(stage.daemon.Log().find("guessed by height and side"), std::string::npos);
}

}  // namespace
}  // namespace styled::support
