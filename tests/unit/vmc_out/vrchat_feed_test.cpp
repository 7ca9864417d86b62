#include "clients/vmc/vrchat_feed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "proto/rigs/vrchat/vrchat.h"
#include "tests/support/units.h"
#include "tests/unit/body/random_pose.h"
#include "tests/unit/clients/fake_daemon.h"
#include "tests/unit/vmc/witness.h"

namespace styled::stylevmc {
namespace {

using body::Quat;
using body::Vec3;
using ::testing::HasSubstr;

using support::kSecond_ns;

v1::Body Puppet() { return client::HumanoidBody("rig.a", v1::OUTPUT_CANONICAL, 5); }

struct Read {
  std::map<int, Vec3> positions;
  std::map<int, Quat> rotations;  // of trackers; mirrored back
  std::map<int, std::array<float, 3>> euler;
};

Read ReadBack(std::span<const std::byte> datagram) {
  Read read;
  vrchat::osc::Reader reader(datagram);
  vrchat::osc::Message bytes;
  while (reader.Next(bytes) == vrchat::osc::Reader::Step::kMessage) {
    vrchat::Message message;
    EXPECT_EQ(vrchat::Decode(bytes, message), vrchat::DecodeResult::kOk);
    const auto& tracker = std::get<vrchat::Tracker>(message);
    if (!tracker.is_rotation) {
      read.positions[tracker.index] = {-tracker.values[0], tracker.values[1], tracker.values[2]};
      continue;
    }
    const auto q = vrchat::QuaternionOf(tracker.values);
    read.rotations[tracker.index] = Quat(q[3], q[0], -q[1], -q[2]);
    read.euler[tracker.index] = tracker.values;
  }
  EXPECT_EQ(reader.result(), vrchat::osc::Result::kOk);
  return read;
}

VrChatFeed Feed(const std::string& trackers, double user_height_m = 0) {
  VrChatFeed feed({ParseTrackerSet(trackers).value(), user_height_m});
  EXPECT_TRUE(feed.Bind(Puppet()).ok());
  return feed;
}

TEST(VrChatFeed, SendsPlacesAndTurnsOfTheTrackersAskedFor) {
  body::Random random(3);
  VrChatFeed feed = Feed("all");
  for (int i = 0; i < 20; ++i) {
    const body::Pose pose = random.AnyPose();
    body::WorldPose world;
    body::ForwardKinematics(pose, world);
    const Read read = ReadBack(feed.Pack(client::HumanoidFrame(Puppet(), pose, 1), i));
    ASSERT_EQ(read.positions.size(), 9U);
    const std::pair<int, int> turned[] = {{body::kHips, body::kHips},
                                          {body::kLeftFoot, body::kLeftFoot},
                                          {body::kRightFoot, body::kRightFoot},
                                          {body::kLeftLowerLeg, body::kLeftUpperLeg},
                                          {body::kRightLowerLeg, body::kRightUpperLeg},
                                          {body::kChest, body::kChest},
                                          {body::kLeftLowerArm, body::kLeftUpperArm},
                                          {body::kRightLowerArm, body::kRightUpperArm}};
    for (int index = 1; index <= 8; ++index) {
      const auto& [at, as] = turned[index - 1];
      EXPECT_LT((read.positions.at(index) - world.positions_m[static_cast<std::size_t>(at)]).norm(),
                1e-4F);
      EXPECT_LT(
          read.rotations.at(index).angularDistance(world.rotations[static_cast<std::size_t>(as)]),
          0.005F);
    }
    EXPECT_LT((read.positions.at(0) - world.positions_m[body::kHead]).norm(), 1e-4F);
  }
}

TEST(VrChatFeed, SendsHipsAndFeetAndScalesToTheUser) {
  VrChatFeed feed = Feed("hip,feet", 1.71 / 2);
  const Read read = ReadBack(feed.Pack(client::HumanoidFrame(Puppet(), {}, 1), 0));
  EXPECT_EQ(read.positions.size(), 4U);
  EXPECT_NEAR(read.positions.at(1).y(), 0.49F, 1e-4F);
  EXPECT_NEAR(read.positions.at(2).x(), 0.045F, 1e-4F) << "2 is the left foot";
}

// By hand: a performer who looks to their left; Unity's y turns the other way.
TEST(VrChatFeed, SendsTheHeadsHeadingOnceAndAtEachReset) {
  body::Pose pose;
  pose.rotations[body::kHips] = Quat(Eigen::AngleAxisf(1.5707964F, Vec3::UnitY()));
  pose.rotations[body::kHead] = Quat(Eigen::AngleAxisf(0.4F, Vec3::UnitX()));
  VrChatFeed feed = Feed("hip");
  const auto heading = [&](std::int64_t now_ns, std::uint32_t flags = 0) {
    auto frame = client::HumanoidFrame(Puppet(), pose, 1);
    frame.set_flags(flags);
    const Read read = ReadBack(feed.Pack(frame, now_ns));
    EXPECT_TRUE(read.positions.contains(0)) << "its place with every frame";
    return read.euler.contains(0);
  };
  const Read first = ReadBack(feed.Pack(client::HumanoidFrame(Puppet(), pose, 1), 0));
  EXPECT_EQ(first.euler.at(0)[0], 0);
  EXPECT_NEAR(first.euler.at(0)[1], -90, 0.01F);
  EXPECT_EQ(first.euler.at(0)[2], 0);
  EXPECT_FALSE(heading(kSecond_ns / 60));
  EXPECT_TRUE(heading(kSecond_ns / 30, v1::FLAG_NEW_SESSION));
  EXPECT_FALSE(heading(kSecond_ns / 20));
  EXPECT_TRUE(heading(2 * kSecond_ns)) << "after a pause";
  EXPECT_TRUE(feed.Bind(Puppet()).ok());
  EXPECT_TRUE(heading(2 * kSecond_ns + 1)) << "another performer";
}

TEST(VrChatFeed, IsReadByOthers) {
  VrChatFeed feed = Feed("all");
  const auto datagram = feed.Pack(client::HumanoidFrame(Puppet(), {}, 1), 0);
  const auto liblo = vmc::testing::ReadLiblo(datagram);
  ASSERT_TRUE(liblo.taken);
  ASSERT_EQ(liblo.messages.size(), 18U);
  EXPECT_EQ(vmc::testing::ReadOscpack(datagram).messages, liblo.messages);
  EXPECT_THAT(liblo.messages[0], ::testing::StartsWith("/tracking/trackers/head/position ,fff "));
}

TEST(VrChatFeed, RefusesABodyThatIsNotTheHumanoid) {
  VrChatFeed feed({ParseTrackerSet("all").value(), 0});
  v1::Body other = Puppet();
  other.set_names(3, "tail");
  EXPECT_THAT(feed.Bind(other).message(), HasSubstr("joint 3 is not 'neck'"));
}

TEST(TrackerSet, IsReadFromWords) {
  EXPECT_EQ(ParseTrackerSet("hip").value(), 0b10U);
  EXPECT_EQ(ParseTrackerSet("feet,knees").value(), 0b111100U);
  EXPECT_EQ(ParseTrackerSet("all").value(), 0b111111110U);
  EXPECT_EQ(ParseTrackerSet("hip,feet,knees,chest,elbows").value(), ParseTrackerSet("all").value());
  for (const char* wrong : {"", "hips", "hip,", ",hip", "hip feet", "ALL"}) {
    EXPECT_THAT(ParseTrackerSet(wrong).status().message(), HasSubstr("expected hip, feet"))
        << wrong;
  }
}

}  // namespace
}  // namespace styled::stylevmc
