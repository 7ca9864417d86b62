// The stand-in's bytes against what the senders it stands for are known to send.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "sim/rigs/vmc.h"
#include "tests/unit/vmc/witness.h"

namespace styled::rigs {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::StartsWith;

// Each datagram's messages, as oscpack reads them.
using Datagrams = std::vector<std::vector<std::string>>;

Datagrams Sent(const std::vector<std::string>& quirks, const body::Pose& pose = {}) {
  Options options;
  options.quirks = quirks;
  auto rig = MakeVmc(options);
  EXPECT_TRUE(rig.ok()) << rig.status().message();
  Datagrams datagrams;
  rig.value()->Encode({3, 0.5, {&pose, 1}}, [&](std::span<const std::byte> bytes) {
    const auto read = vmc::testing::ReadOscpack(bytes);
    EXPECT_TRUE(read.taken);
    datagrams.push_back(read.messages);
  });
  return datagrams;
}

TEST(VmcStandIn, AnUnknownQuirkOrASecondPerformerIsRefused) {
  Options unknown, two;
  unknown.quirks = {"t-last"};
  two.performers = {"a", "b"};
  EXPECT_FALSE(MakeVmc(unknown).ok());
  EXPECT_FALSE(MakeVmc(two).ok());
  EXPECT_EQ(MakeVmc({}).value()->default_address(), "udp://127.0.0.1:39540");
}

TEST(VmcStandIn, SendsAsTheApplicationBonesThenExpressionsThenTheRestWithTLast) {
  const Datagrams sent = Sent({});
  ASSERT_EQ(sent.size(), 3U);
  EXPECT_EQ(sent[0].size(), 13U);
  EXPECT_THAT(sent[0][0], StartsWith("/VMC/Ext/Bone/Pos ,sfffffff Hips "));
  EXPECT_THAT(sent[0][0], EndsWith(" 3f800000"));
  EXPECT_THAT(sent[0][12], StartsWith("/VMC/Ext/Bone/Pos ,sfffffff RightShoulder"));
  EXPECT_EQ(sent[1].back(), "/VMC/Ext/Blend/Apply ,");
  ASSERT_EQ(sent[2].size(), 11U);
  EXPECT_EQ(sent[2][0],
            "/VMC/Ext/Root/Pos ,sfffffffffffff root 00000000 00000000 00000000 00000000 00000000 "
            "00000000 3f800000 3f800000 3f800000 3f800000 00000000 00000000 00000000");
  EXPECT_EQ(sent[2][9], "/VMC/Ext/OK ,iii 1 3 0");
  EXPECT_EQ(sent[2][10], "/VMC/Ext/T ,f 3f000000");
}

TEST(VmcStandIn, SendsAsSlimeVrOneDatagramWithTFirstAndWNegative) {
  for (const char* quirk : {"t-first", "nested"}) {
    const Datagrams sent = Sent({quirk});
    ASSERT_EQ(sent.size(), 1U);
    ASSERT_EQ(sent[0].size(), 24U);
    EXPECT_EQ(sent[0][0], "/VMC/Ext/T ,f 3f000000");
    EXPECT_EQ(sent[0][1], "/VMC/Ext/OK ,i 1");
    EXPECT_THAT(sent[0][2], StartsWith("/VMC/Ext/Root/Pos ,sfffffff root"));
  }
  EXPECT_THAT(Sent({"t-first"})[0][5], EndsWith(" bf800000"));
  EXPECT_THAT(Sent({"nested"})[0][5], EndsWith(" 3f800000"));
}

TEST(VmcStandIn, SendsSingleMessages) {
  const Datagrams sent = Sent({"single", "full"});
  ASSERT_EQ(sent.size(), 58U);
  for (const auto& datagram : sent) EXPECT_EQ(datagram.size(), 1U);
  EXPECT_THAT(sent[55][0], StartsWith("/VMC/Ext/Bone/Pos ,sfffffff UpperChest"));
  EXPECT_EQ(sent[57][0], "/VMC/Ext/T ,f 3f000000");
  EXPECT_EQ(Sent({"single", "no-t"}).back(),
            (std::vector<std::string>{"/VMC/Ext/OK ,iiii 1 3 0 1"}));
}

TEST(VmcStandIn, NamesThumbsAsVrm1Does) {
  const Datagrams sent = Sent({"single", "full", "vrm1"});
  EXPECT_THAT(sent[1][0], StartsWith("/VMC/Ext/Bone/Pos ,sfffffff hips "));
  EXPECT_THAT(sent[25][0], StartsWith("/VMC/Ext/Bone/Pos ,sfffffff leftThumbMetacarpal "));
  EXPECT_THAT(sent[26][0], StartsWith("/VMC/Ext/Bone/Pos ,sfffffff leftThumbProximal "));
  EXPECT_THAT(sent[27][0], StartsWith("/VMC/Ext/Bone/Pos ,sfffffff leftThumbDistal "));
}

// Unity: +X is the body's right.
TEST(VmcStandIn, MirrorsWhatItSends) {
  body::Pose pose;
  pose.hips_position_m = {0.25F, 1, 0.5F};
  pose.rotations[body::kHips] = {0.5F, 0.5F, 0.5F, 0.5F};
  EXPECT_EQ(Sent({"single"}, pose)[1][0],
            "/VMC/Ext/Bone/Pos ,sfffffff Hips be800000 3f800000 3f000000 3f000000 bf000000 "
            "bf000000 3f000000");
}

TEST(VmcStandIn, LeavesOutWhatIsNotTracked) {
  body::Pose pose;
  pose.rotations[body::kLeftHand].x() = std::numeric_limits<float>::quiet_NaN();
  const Datagrams whole = Sent({"single"}), sent = Sent({"single"}, pose);
  EXPECT_EQ(sent.size(), whole.size() - 1);
  for (const auto& datagram : sent) {
    EXPECT_THAT(datagram[0], ::testing::Not(::testing::HasSubstr("LeftHand ")));
  }
}

}  // namespace
}  // namespace styled::rigs
