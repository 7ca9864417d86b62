#include "proto/rigs/qtm/packet.h"

#include <gtest/gtest.h>

#include "tests/unit/qtm/bytes.h"

namespace styled::qtm {
namespace {

using namespace testing;
using rigs::Cut;

DecodeResult Decoded(const Bytes& bytes) {
  Packet packet;
  return DecodePacket(bytes, packet);
}

TEST(QtmPacket, IsRefusedForEachReason) {
  EXPECT_EQ(Decoded({}), DecodeResult::kTooShort);
  EXPECT_EQ(Decoded(Bytes(7)), DecodeResult::kTooShort);
  EXPECT_EQ(Decoded(Join(U32{12}, U32{1}, Any{3})), DecodeResult::kSizeMismatch);
  EXPECT_EQ(Decoded(Join(U32{0}, U32{1})), DecodeResult::kSizeMismatch);
  EXPECT_EQ(Decoded(Pack(9, Any{4})), DecodeResult::kBadType);
  EXPECT_EQ(Decoded(Pack(1, Any{kMaxTextSize})), DecodeResult::kTooLarge);
  EXPECT_EQ(Decoded(Pack(3, Any{kMaxPacketSize})), DecodeResult::kTooLarge);
  EXPECT_EQ(Decoded(Pack(2, Any{kMaxXmlSize})), DecodeResult::kTooLarge);
  EXPECT_EQ(Decoded(Pack(4, Any{1})), DecodeResult::kTooLarge);
  EXPECT_EQ(Decoded(Pack(3, Any{15})), DecodeResult::kTruncated);
  EXPECT_EQ(Decoded(Pack(6)), DecodeResult::kTruncated);
}

TEST(QtmPacket, HasTypeAndPayload) {
  Packet packet;
  const Bytes error = Error("Parse error"), version = Pack(1, Text{"Version 1.19", false}),
              empty = Pack(1);
  ASSERT_EQ(DecodePacket(error, packet), DecodeResult::kOk);
  EXPECT_EQ(packet.type, PacketType::kError);
  EXPECT_EQ(TextOf(packet.payload), "Parse error");
  // JavaScript's client ends its texts without a NUL.
  ASSERT_EQ(DecodePacket(version, packet), DecodeResult::kOk);
  EXPECT_EQ(TextOf(packet.payload), "Version 1.19");
  ASSERT_EQ(DecodePacket(empty, packet), DecodeResult::kOk);
  EXPECT_EQ(TextOf(packet.payload), "");
}

TEST(QtmPacket, WrittenIsByteForByteAsTheProtocolHasIt) {
  Bytes out(64);
  const auto written = [&out](std::size_t size) {
    return Bytes(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size));
  };
  EXPECT_EQ(written(EncodeText(PacketType::kCommand, "GetState", out)), Command("GetState"));
  EXPECT_EQ(written(EncodeEvent(Event::kCaptureStarted, out)), EventOf(3));
  EXPECT_EQ(written(EncodeNoMoreData(out)), Pack(4));
  EXPECT_EQ(EncodeText(PacketType::kXml, std::string(56, 'x'), out), 0U) << "no room for the NUL";
}

TEST(QtmStream, IsCutIntoPacketsWhereverItsSegmentsEnd) {
  const std::vector<Bytes> packets{Command("QTM RT Interface connected"), Pack(4), EventOf(3),
                                   Data(1, 2), Xml("<a/>")};
  Bytes stream;
  for (const Bytes& packet : packets) Part{packet}.AppendTo(stream);
  for (std::size_t end = 0; end <= stream.size(); ++end) {
    std::span<const std::byte> received = std::span(stream).first(end);
    std::size_t found = 0, size = 0;
    while (CutPacket(received, size) == Cut::kRecord) {
      ASSERT_LT(found, packets.size());
      ASSERT_EQ(Bytes(received.begin(), received.begin() + static_cast<std::ptrdiff_t>(size)),
                packets[found++]);
      received = received.subspan(size);
    }
    ASSERT_EQ(CutPacket(received, size), Cut::kNeedMore) << end;
  }
}

TEST(QtmStream, IsBrokenByItsHeaderAloneBeforeThePayloadHasCome) {
  const auto broken = [](std::uint64_t header_size, std::uint32_t type) {
    std::size_t size = 77;
    const Bytes header = Join(U32{header_size}, U32{type});
    if (CutPacket(header, size) != Cut::kBroken) return std::string();
    EXPECT_EQ(size, 77U) << "written";
    return WhyBroken(header);
  };
  EXPECT_EQ(broken(0xFFFFFFFF, 3),
            "a packet of type 3 with 4294967295 bytes, expected 24 to 2031616");
  EXPECT_EQ(broken(7, 3), "a packet of type 3 with 7 bytes, expected 24 to 2031616");
  EXPECT_EQ(broken(5000, 1), "a packet of type 1 with 5000 bytes, expected 8 to 4096");
  EXPECT_EQ(broken(10, 6), "a packet of type 6 with 10 bytes, expected 9 to 9");
  // The big-endian port's greeting.
  EXPECT_EQ(broken(0x23000000, 0x01000000),
            "a packet of type 16777216, expected 0 to 8 of QTM RT, little-endian (port 22223)");
  EXPECT_EQ(broken(kMaxPacketSize, 3), "");
  EXPECT_EQ(broken(kMaxXmlSize, 2), "");
  EXPECT_EQ(broken(kMaxXmlSize + 1, 2),
            "a packet of type 2 (parameters) with 8388609 bytes, expected 8 to 8388608");
}

TEST(QtmText, IsShownOnOneShortLine) {
  EXPECT_EQ(ToString("a\nb\x01\xC3\xA9"), "a?b???");
  EXPECT_EQ(ToString(std::string(1000, 'x')).size(), 200U);
}

TEST(QtmText, ServerTextIsKnownInAnyCaseOfLetters) {
  EXPECT_TRUE(IsGreeting("QTM RT Interface connected"));
  EXPECT_TRUE(IsGreeting("qtm rt INTERFACE connected."));
  EXPECT_FALSE(IsGreeting("QTM RT Interface"));
  EXPECT_FALSE(IsGreeting("220 ftp"));
  EXPECT_FALSE(IsGreeting(""));
  EXPECT_TRUE(AcceptsVersion("Version set to 1.25"));
  EXPECT_TRUE(AcceptsVersion("version SET to 1.19"));
  EXPECT_FALSE(AcceptsVersion("Version NOT supported"));
}

}  // namespace
}  // namespace styled::qtm
