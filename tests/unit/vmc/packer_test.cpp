#include "proto/rigs/vmc/packer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/rigs/vmc/bones.h"
#include "tests/unit/vmc/bytes.h"

namespace styled::vmc {
namespace {

using testing::Bytes;

// The addresses of each datagram, without "/VMC/Ext/".
using Datagrams = std::vector<std::vector<std::string>>;

Datagrams Pack(const Packed& frame) {
  Datagrams datagrams;
  Bytes buffer(4096);
  Packer packer(frame);
  while (const std::size_t size = packer.Next(buffer)) {
    EXPECT_LE(size, Packer::kMaxPacketSize);
    datagrams.emplace_back();
    const std::span<const std::byte> datagram(buffer.data(), size);
    osc::Reader reader(datagram);
    osc::Message message;
    while (reader.Next(message) == osc::Reader::Step::kMessage) {
      datagrams.back().emplace_back(
          message.address.substr(message.address.starts_with("/VMC/Ext/") ? 9 : 0));
    }
    EXPECT_EQ(reader.result(), osc::Result::kOk);
  }
  EXPECT_EQ(packer.Next(buffer), 0U);
  return datagrams;
}

std::vector<Bone> AllBones() {
  std::vector<Bone> bones;
  for (const BoneRow& row : kBones) bones.push_back({row.name, {}});
  return bones;
}

TEST(Packer, SendsAtMostThirteenBonesInADatagramAndTheRootFirst) {
  const auto bones = AllBones();
  Packed frame;
  frame.bones = bones;
  const Datagrams datagrams = Pack(frame);
  ASSERT_EQ(datagrams.size(), 6U);
  EXPECT_EQ(datagrams[0][0], "Root/Pos");
  for (std::size_t i = 0; i < 5; ++i) {
    const auto count = std::count(datagrams[i].begin(), datagrams[i].end(), "Bone/Pos");
    EXPECT_EQ(count, i < 4 ? 13 : 3) << i;
  }
}

// EVMC4U takes a T that comes last for the end of a frame, VMCLiveLink publishes at Apply.
TEST(Packer, EndsEveryFrameWithApplyOkAndT) {
  const auto bones = AllBones();
  std::vector<std::string> names;
  for (int i = 0; i < 200; ++i) names.push_back("expression" + std::to_string(i));
  std::vector<Blend> blends;
  for (const auto& name : names) blends.push_back({name, 0.5F});
  for (const std::size_t count : {0U, 1U, 5U, 17U, 26U, 27U, 28U, 29U, 30U, 52U, 200U}) {
    Packed frame;
    frame.bones = bones;
    frame.blends = std::span(blends).first(count);
    const Datagrams datagrams = Pack(frame);
    const auto& last = datagrams.back();
    ASSERT_GE(last.size(), 3U);
    EXPECT_THAT((std::vector<std::string>(last.end() - 3, last.end())),
                ::testing::ElementsAre("Blend/Apply", "OK", "T"));
    std::size_t seen = 0;
    for (const auto& datagram : datagrams) {
      seen += static_cast<std::size_t>(std::count(datagram.begin(), datagram.end(), "Blend/Val"));
    }
    EXPECT_EQ(seen, count);
  }
}

TEST(Packer, SendsTheRootAndTheEndWhereThereAreNoBones) {
  EXPECT_EQ(Pack({}), (Datagrams{{"Root/Pos"}, {"Blend/Apply", "OK", "T"}}));
}

TEST(Packer, PassesThrusOnAndLeavesOutWhatNoDatagramCouldHold) {
  const Bytes thru = testing::S("/VMC/Thru/a/b") + testing::S(",s") + testing::S("word");
  const Bytes vast =
      testing::S("/VMC/Thru/a/vast") + testing::S(",s") + testing::S(std::string(2000, 'x'));
  const std::vector<Thru> thrus{{thru}, {vast}, {thru}};
  const std::string long_name(2000, 'y');
  const std::vector<Blend> blends{{long_name, 1}, {"Joy", 1}};
  Packed frame;
  frame.thrus = thrus;
  frame.blends = blends;
  EXPECT_EQ(Pack(frame),
            (Datagrams{{"Root/Pos"},
                       {"/VMC/Thru/a/b", "/VMC/Thru/a/b", "Blend/Val", "Blend/Apply", "OK", "T"}}));
}

}  // namespace
}  // namespace styled::vmc
