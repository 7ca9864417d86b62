#include "clients/doctor/capture.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "tests/unit/slimevr/decode_cases.h"

namespace styled::doctor {
namespace {

using slimevr::testing::Bytes;
using slimevr::testing::Hex;
using slimevr::testing::Join;

// Headers written by hand from RFC 791, 768 and 8200: from 192.0.2.9:50000 to 192.0.2.1:9763.
const Bytes kUdpHeader = Hex("C3 50 26 23 00 0C 00 00");  // 4 bytes of payload
const Bytes kPayload = Hex("4D 58 54 50");
Bytes IPv4(std::string_view length, std::string_view fragment, std::string_view protocol = "11") {
  return Join({Hex("45 00"), Hex(length), Hex("12 34"), Hex(fragment), Hex("40"), Hex(protocol),
               Hex("00 00 C0 00 02 09 C0 00 02 01")});
}
Bytes IPv6(std::string_view next) {
  return Join({Hex("60 00 00 00 00 0C"), Hex(next), Hex("40"),
               Hex("FD 00 00 00 00 00 00 00 00 00 00 00 00 00 00 09"),
               Hex("FD 00 00 00 00 00 00 00 00 00 00 00 00 00 00 01")});
}
const Bytes kWhole = Join({IPv4("00 20", "00 00"), kUdpHeader, kPayload});

TEST(CaptureTest, WhatIsNoUdpIsPassedOver) {
  const std::vector<std::pair<std::string, Bytes>> cases{
      {"nothing", {}},
      {"ARP", Hex("00 01 08 00 06 04 00 01 AA BB CC DD EE FF C0 00 02 09 00 00 00 00 00 00")},
      {"TCP", Join({IPv4("00 20", "00 00", "06"), kUdpHeader, kPayload})},
      {"TCP over IPv6", Join({IPv6("06"), kUdpHeader, kPayload})},
      {"a later fragment", Join({IPv4("00 20", "00 B9"), kUdpHeader, kPayload})},
      {"a header cut", Bytes(kWhole.begin(), kWhole.begin() + 19)},
      {"UDP's header cut", Bytes(kWhole.begin(), kWhole.begin() + 27)},
      {"a total length below the header's", Join({IPv4("00 13", "00 00"), kUdpHeader, kPayload})},
      {"a header length of 4 words", Join({Hex("44"), Bytes(kWhole.begin() + 1, kWhole.end())})},
      {"a header length past the end", Join({Hex("4F"), Bytes(kWhole.begin() + 1, kWhole.end())})},
      {"a UDP length of 7", Join({IPv4("00 20", "00 00"), Hex("C3 50 26 23 00 07 00 00")})},
      {"IPv6 cut", Join({IPv6("11"), Hex("C3 50")})}};
  for (const auto& [name, bytes] : cases) EXPECT_FALSE(ParsePacket(bytes)) << name;
}

TEST(CaptureTest, APacketHasBothEndsAndItsPayload) {
  const auto packet = ParsePacket(kWhole);
  ASSERT_TRUE(packet);
  EXPECT_EQ(ToString(packet->from), "192.0.2.9:50000");
  EXPECT_EQ(ToString(packet->to), "192.0.2.1:9763");
  EXPECT_FALSE(packet->cut);
  EXPECT_EQ(Bytes(packet->payload.begin(), packet->payload.end()), kPayload);
  const Bytes six = Join({IPv6("11"), kUdpHeader, kPayload});
  const auto packet6 = ParsePacket(six);
  ASSERT_TRUE(packet6);
  EXPECT_EQ(ToString(packet6->from), "[fd00::9]:50000");
  EXPECT_EQ(ToString(packet6->to), "[fd00::1]:9763");
  EXPECT_EQ(packet6->payload.size(), 4U);
}

// Short Ethernet frames are filled up to 60 bytes.
TEST(CaptureTest, PaddingBehindThePacketIsNotPayload) {
  const Bytes padded = Join({kWhole, Bytes(14)});
  const auto packet = ParsePacket(padded);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->payload.size(), 4U);
}

TEST(CaptureTest, TheFirstOfSeveralFragmentsIsCut) {
  const Bytes large = Join({IPv4("00 20", "20 00"), Hex("C3 50 26 23 10 00 00 00"), kPayload});
  const auto packet = ParsePacket(large);
  ASSERT_TRUE(packet);
  EXPECT_TRUE(packet->cut);
  EXPECT_EQ(packet->payload.size(), 4U);
}

// A session of a Motive 2.1 server, captured by the authors of mje-nz/python_natnet (BSD-3).
TEST(CaptureTest, OfARealSessionEveryDatagramIsReadAndNoneIsTakenForAnotherFormat) {
  const char* set = std::getenv("STYLED_DATA");
  const std::filesystem::path folder = set != nullptr ? set : STYLED_DATA_DEFAULT;
  std::ifstream in(folder / "packets" / "traffic.pcapng", std::ios::binary);
  const std::string file{std::istreambuf_iterator<char>(in), {}};
  if (file.empty()) GTEST_SKIP() << "skipped, no data";
  const auto u32 = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, &file.at(at), sizeof value);
    return value;
  };
  Sniffer sniffer;
  std::map<std::string, int> count;
  // Enhanced Packet Blocks, Ethernet.
  for (std::size_t at = 0; at + 12 <= file.size(); at += u32(at + 4)) {
    if (u32(at) != 6) continue;
    const auto size = static_cast<std::size_t>(u32(at + 20)) - 14;
    const auto packet = ParsePacket(std::as_bytes(std::span(file)).subspan(at + 28 + 14, size));
    ASSERT_TRUE(packet) << at;
    const Sniffed what = sniffer.Sniff(packet->payload);
    const bool to_client = packet->to.host == "239.255.42.99" || packet->from.port == 1510;
    ++count[what.format == Format::kNatNet
                ? what.kind
                : std::string("other ") + (to_client ? "answer" : "question") + " " +
                      std::string(Row(what.format).word)];
  }
  EXPECT_EQ(count["frames without a skeleton"], 518);
  EXPECT_GE(count["server of NatNet 3.0"], 1);
  EXPECT_GE(count["model without a skeleton"], 1);
  for (const auto& [what, number] : count) {
    if (!what.starts_with("other")) continue;
    EXPECT_TRUE(what.ends_with("unknown")) << what << " " << number;
  }
}

}  // namespace
}  // namespace styled::doctor
