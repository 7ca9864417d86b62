// The output of stylevmc for VRChat is a body again in a source of type "vrchat".
#include <gtest/gtest.h>

#include "clients/vmc/vrchat_feed.h"
#include "daemon/source/rigs/vrchat.h"
#include "model/synthetic/performer.h"
#include "tests/support/translation.h"
#include "tests/unit/clients/fake_daemon.h"

namespace styled::source {
namespace {

constexpr std::int64_t kSent_ns = 10'000'000;

// The worst over a motion: rotations in the world of the parts with trackers, degrees; places of
// hips, feet and head, cm.
struct Worst {
  float deg = 0, cm = 0;
};

Worst PlayThrough(const std::string& trackers, double user_height_m,
                  const std::vector<int>& turned) {
  const v1::Body body = client::HumanoidBody("rig.a", v1::OUTPUT_CANONICAL, 5);
  stylevmc::VrChatFeed feed({stylevmc::ParseTrackerSet(trackers).value(), user_height_m});
  EXPECT_TRUE(feed.Bind(body).ok());
  config::Source config;
  config.name = "stage";
  config.type = "vrchat";
  support::Translated in(MakeVrChat(config));
  const auto show = [&](const body::Pose& pose, int frames) {
    for (int i = 0; i < frames; ++i) {
      in.Handle(feed.Pack(client::HumanoidFrame(body, pose, 1), in.now_ns));
      in.now_ns += kSent_ns;
      in.Tick();
    }
  };
  show({}, 20);
  EXPECT_TRUE(in.translator().Calibrate(Calibration::kFull, in.now_ns).ok());
  synthetic::Options options;
  options.script = synthetic::ParseScript("walk:2,wave-left:2,turn-left:2").value();
  synthetic::Performer performer(options);
  Worst worst;
  for (double time_s = 0.3; time_s < 6; time_s += 0.4) {
    body::Pose pose;
    performer.Pose(time_s, pose);
    show(pose, 10);
    const auto found = support::CanonicalPose(in.Bodies().back(), in.Frames().back());
    EXPECT_TRUE(found.has_value());
    if (!found) return worst;
    body::WorldPose a, b;
    body::ForwardKinematics(*found, a);
    body::ForwardKinematics(pose, b);
    for (const int part : turned) {
      const auto j = static_cast<std::size_t>(part);
      worst.deg = std::max(worst.deg, 57.29578F * a.rotations[j].angularDistance(b.rotations[j]));
    }
    for (const int part : {body::kHips, body::kLeftFoot, body::kRightFoot}) {
      const auto j = static_cast<std::size_t>(part);
      worst.cm = std::max(worst.cm, 100 * (a.positions_m[j] - b.positions_m[j]).norm());
    }
  }
  return worst;
}

TEST(RoundTrip, HipsAndFeetComeBack) {
  const Worst worst = PlayThrough("hip,feet", 0, {body::kHips, body::kLeftFoot, body::kRightFoot});
  EXPECT_LT(worst.deg, 1);
  EXPECT_LT(worst.cm, 2);
  std::printf("hip and feet: %.2f degrees, %.2f cm at most\n", static_cast<double>(worst.deg),
              static_cast<double>(worst.cm));
}

TEST(RoundTrip, AllTrackersComeBackOfAUserOfAnotherSize) {
  const Worst worst =
      PlayThrough("all", 1.2,
                  {body::kHips, body::kLeftFoot, body::kRightFoot, body::kLeftUpperLeg,
                   body::kRightUpperLeg, body::kChest, body::kLeftUpperArm, body::kRightUpperArm});
  EXPECT_LT(worst.deg, 1);
  EXPECT_LT(worst.cm, 2);
  std::printf("all: %.2f degrees, %.2f cm at most\n", static_cast<double>(worst.deg),
              static_cast<double>(worst.cm));
}

}  // namespace
}  // namespace styled::source
