#include "proto/ptp/management.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

namespace styled::ptp {
namespace {

std::vector<std::byte> FromHex(std::string_view hex) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

// Replies of linuxptp 3.1.1, a slave of domain 127 by software time stamps. Its pmc prints:
// grandmasterPriority1 100, gm.ClockClass 248, gm.ClockAccuracy 0xfe, grandmasterPriority2 128,
// grandmasterIdentity f6f17c.fffe.9588b8; stepsRemoved 1; portState UNCALIBRATED; timeSource 0xa0.
constexpr std::string_view kParent =
    "0d0200567f000000000000000000000000000000fa765ffffe7952dc00000000047f0000000000000000000100000"
    "200000100222002f6f17cfffe9588b800010000ffff7fffffff64f8feffff80f6f17cfffe9588b8";
constexpr std::string_view kCurrent =
    "0d0200487f000000000000000000000000000000fa765ffffe7952dc00000001047f0000000000000000000100000"
    "2000001001420010001fffffffffde600000000000009760000";
constexpr std::string_view kPort =
    "0d0200507f000000000000000000000000000000fa765ffffe7952dc00010002047f0000000000000000000100000"
    "2000001001c2004fa765ffffe7952dc000108000000000000000000fe03fd010002";
constexpr std::string_view kProperties =
    "0d02003a7f000000000000000000000000000000fa765ffffe7952dc00000003047f0000000000000000000100000"
    "20000010006200300250"
    "0a0";

TEST(PtpManagement, TheRepliesOfARealPtp4l) {
  const auto parent = Read(FromHex(kParent));
  ASSERT_TRUE(parent && std::holds_alternative<Parent>(parent->data));
  EXPECT_EQ(parent->domain, 127);
  const Parent& leader = std::get<Parent>(parent->data);
  EXPECT_EQ(Text(leader.leader), "f6f17c.fffe.9588b8");
  EXPECT_EQ(leader.priority1, 100);
  EXPECT_EQ(leader.priority2, 128);
  EXPECT_EQ(leader.clock_class, 248);
  EXPECT_EQ(leader.accuracy, 0xfe);
  const auto current = Read(FromHex(kCurrent));
  ASSERT_TRUE(current && std::holds_alternative<Current>(current->data));
  EXPECT_EQ(std::get<Current>(current->data).steps_removed, 1);
  EXPECT_NEAR(std::get<Current>(current->data).offset_s, -538e-9, 1e-15);
  EXPECT_NEAR(std::get<Current>(current->data).mean_path_delay_s, 2422e-9, 1e-15);
  const auto port = Read(FromHex(kPort));
  ASSERT_TRUE(port && std::holds_alternative<Port>(port->data));
  EXPECT_EQ(std::get<Port>(port->data).number, 1);
  EXPECT_EQ(Text(std::get<Port>(port->data).state), "UNCALIBRATED");
  const auto properties = Read(FromHex(kProperties));
  ASSERT_TRUE(properties && std::holds_alternative<TimeProperties>(properties->data));
  EXPECT_EQ(std::get<TimeProperties>(properties->data).time_source, 0xa0);
}

TEST(PtpManagement, AnInvalidReplyIsIgnored) {
  EXPECT_FALSE(Read({}));
  const auto request = Get(DataSet::kParent, 3, 9);
  EXPECT_EQ(request.size(), kRequestBytes);
  EXPECT_FALSE(Read(request)) << "a question";
  const auto good = FromHex(kParent);
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(Read(std::span(good).first(size))) << size;
  }
  auto error = good;
  error[49] = std::byte{2};  // MANAGEMENT_ERROR_STATUS
  EXPECT_FALSE(Read(error));
  auto other = good;
  other[52] = std::byte{0x77};
  EXPECT_FALSE(Read(other));
}

TEST(PtpManagement, AnyBytesAreBorne) {
  std::mt19937 random(1);
  int read = 0;
  for (const std::string_view hex : {kParent, kCurrent, kPort, kProperties}) {
    const auto good = FromHex(hex);
    for (int i = 0; i < 20'000; ++i) {
      auto bad = good;
      for (int changes = 0; changes < 3; ++changes) {
        bad[random() % bad.size()] = static_cast<std::byte>(random());
      }
      if (i % 3 == 0) bad.resize(random() % bad.size());
      const auto reply = Read(bad);
      if (!reply) continue;
      ++read;
      if (const auto* port = std::get_if<Port>(&reply->data)) {
        EXPECT_NE(Text(port->state), "");
      }
    }
  }
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace styled::ptp
