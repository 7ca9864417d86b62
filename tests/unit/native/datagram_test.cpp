#include "proto/rigs/native/datagram.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "model/base/crc32c.h"
#include "tests/unit/native/decode_cases.h"

namespace styled::native {
namespace {

using testing::Bytes;

TEST(Datagram, EveryCaseOfTheTableGivesItsReason) {
  for (const testing::DecodeCase& c : testing::DecodeCases()) {
    Datagram datagram;
    EXPECT_EQ(Name(Decode(c.bytes, datagram)), Name(c.expected)) << c.name;
  }
}

TEST(Datagram, EveryReasonIsReachedByTheTable) {
  for (int reason = 0; reason < static_cast<int>(DecodeResult::kCount); ++reason) {
    const auto cases = testing::DecodeCases();
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [reason](const auto& c) {
      return static_cast<int>(c.expected) == reason;
    })) << Name(DecodeResult(reason));
  }
}

TEST(Datagram, IsLeftAloneByARefusedOne) {
  for (const testing::DecodeCase& c : testing::DecodeCases()) {
    Datagram datagram{Kind::kBody, 42, 43, {}};
    if (Decode(c.bytes, datagram) == DecodeResult::kOk) continue;
    EXPECT_EQ(datagram.session, 42U) << c.name;
    EXPECT_EQ(datagram.sequence, 43U) << c.name;
    EXPECT_TRUE(datagram.payload.empty()) << c.name;
  }
}

TEST(Datagram, IsLaidOutAsTheWireDocumentSays) {
  const Bytes bytes = testing::MakeDatagram(Kind::kSourceFrame, 0x0807060504030201ULL,
                                            0x1817161514131211ULL, testing::ToBytes("abc"));
  Bytes expected = testing::ToBytes("STYD");
  for (int value : {1, 2, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0}) expected.push_back(std::byte(value));
  for (int value = 1; value <= 8; ++value) expected.push_back(std::byte(value));
  for (int value = 0x11; value <= 0x18; ++value) expected.push_back(std::byte(value));
  for (char c : {'a', 'b', 'c'}) expected.push_back(std::byte(c));
  const std::uint32_t crc = Crc32c(expected);
  for (int i = 0; i < 4; ++i) expected[12 + i] = std::byte((crc >> (8 * i)) & 0xFF);
  EXPECT_EQ(bytes, expected);
}

TEST(Datagram, ComesBackAsItWasSent) {
  const Bytes payload = testing::ToBytes("some payload");
  const Bytes bytes = testing::MakeDatagram(Kind::kBody, 5, 6, payload);
  Datagram datagram;
  ASSERT_EQ(Decode(bytes, datagram), DecodeResult::kOk);
  EXPECT_EQ(datagram.kind, Kind::kBody);
  EXPECT_EQ(datagram.session, 5U);
  EXPECT_EQ(datagram.sequence, 6U);
  EXPECT_TRUE(std::ranges::equal(datagram.payload, payload));
}

TEST(Datagram, ChecksOutWithItsPayloadEncodedInPlace) {
  const Bytes payload = testing::ToBytes("in place");
  Bytes out(kHeaderSize + payload.size());
  std::copy(payload.begin(), payload.end(), out.begin() + kHeaderSize);
  const auto in_place = std::span<const std::byte>(out).subspan(kHeaderSize);
  ASSERT_EQ(Encode({Kind::kBody, 5, 6, in_place}, out), out.size());
  EXPECT_EQ(out, testing::MakeDatagram(Kind::kBody, 5, 6, payload));
}

TEST(Datagram, IsNotWrittenWhereItDoesNotFit) {
  Bytes out(kHeaderSize + 3, std::byte{9});
  const Bytes untouched = out;
  EXPECT_EQ(Encode({Kind::kBody, 1, 0, testing::ToBytes("four")}, out), 0U);
  EXPECT_EQ(Encode({Kind::kBody, 0, 0, testing::ToBytes("abc")}, out), 0U);
  EXPECT_EQ(out, untouched);
  Bytes large(kMaxDatagramSize + 1);
  EXPECT_EQ(Encode({Kind::kBody, 1, 0, Bytes(kMaxPayloadSize + 1)}, large), 0U);
}

TEST(Datagram, WithAnySingleBitFlippedIsRefused) {
  const Bytes good =
      testing::MakeDatagram(Kind::kSourceFrame, 99, 3, testing::ToBytes("0123456789"));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= std::byte(1U << (bit % 8));
    Datagram datagram;
    EXPECT_NE(Decode(bad, datagram), DecodeResult::kOk) << "bit " << bit;
  }
}

// RFC 3720, appendix B.4, and the usual check value.
TEST(Crc32c, HasTheValuesOfRfc3720) {
  Bytes ascending(32), descending(32);
  for (int i = 0; i < 32; ++i) {
    ascending[i] = std::byte(i);
    descending[i] = std::byte(31 - i);
  }
  EXPECT_EQ(Crc32c(Bytes(32, std::byte{0x00})), 0x8A9136AAU);
  EXPECT_EQ(Crc32c(Bytes(32, std::byte{0xFF})), 0x62A8AB43U);
  EXPECT_EQ(Crc32c(ascending), 0x46DD794EU);
  EXPECT_EQ(Crc32c(descending), 0x113FDB5CU);
  EXPECT_EQ(Crc32c(testing::ToBytes("123456789")), 0xE3069283U);
  EXPECT_EQ(Crc32c({}), 0U);
  // An iSCSI Read (10) command PDU.
  Bytes command(48);
  for (auto [at, value] : {std::pair{0, 0x01},
                           {1, 0xC0},
                           {16, 0x14},
                           {22, 0x04},
                           {27, 0x14},
                           {31, 0x18},
                           {32, 0x28},
                           {40, 0x02}}) {
    command[at] = std::byte(value);
  }
  EXPECT_EQ(Crc32c(command), 0xD9963A56U);
}

}  // namespace
}  // namespace styled::native
