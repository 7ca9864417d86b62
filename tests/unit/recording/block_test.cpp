#include "proto/recording/block.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <string>

#include "tests/unit/recording/samples.h"

namespace styled::recording {
namespace {

using testing::Bytes;
using testing::MakeRecord;

std::span<const std::byte, kBlockHeaderSize> HeaderOf(std::span<const std::byte> block) {
  return block.first<kBlockHeaderSize>();
}

Bytes FromHex(const std::string& text) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size();) {
    if (text[i] == ' ') {
      ++i;
      continue;
    }
    bytes.push_back(static_cast<std::byte>(std::stoi(text.substr(i, 2), nullptr, 16)));
    i += 2;
  }
  return bytes;
}

// Written out by hand from FORMAT.md; both checksums are of another program (Python's crc32c).
TEST(BlockTest, ABlockWrittenByHandFromTheFormatIsReadAndWrittenTheSame) {
  const Bytes bytes = FromHex(
      "F5 53 42 4B  02 00  00 00  06 00 00 00  06 00 00 00  01 00 00 00  14 9C 50 53  "
      "07 00 00 00 00 00 00 00  FE FF FF FF FF FF FF FF  05 00 00 00  52 D5 ED 4B");
  ASSERT_EQ(bytes.size(), kBlockHeaderSize);
  const auto header = DecodeBlockHeader(HeaderOf(bytes));
  ASSERT_TRUE(header.has_value());
  EXPECT_EQ(header->type, 2);
  EXPECT_EQ(header->compression, 0);
  EXPECT_EQ(header->stored_size, 6U);
  EXPECT_EQ(header->raw_size, 6U);
  EXPECT_EQ(header->records, 1U);
  EXPECT_EQ(header->first_time_ns, 7);
  EXPECT_EQ(header->last_time_ns, -2);
  EXPECT_EQ(header->number, 5U);
  EXPECT_EQ(header->payload_crc, Checksum(FromHex("05 08 07 2A 01 00")));
  std::array<std::byte, kBlockHeaderSize> again{};
  EncodeBlockHeader(*header, again);
  EXPECT_TRUE(std::ranges::equal(again, bytes));
}

TEST(BlockTest, TheChecksumIsThatOfRfc3720) {
  EXPECT_EQ(Checksum(std::as_bytes(std::span("123456789", 9))), 0xE3069283U);
}

TEST(BlockTest, AHeaderWithAnyBitFlippedIsNone) {
  BlockBuilder builder;
  ASSERT_TRUE(builder.Add(MakeRecord(0)));
  const auto block = builder.Close();
  for (std::size_t bit = 0; bit < 8 * kBlockHeaderSize; ++bit) {
    Bytes damaged(block.begin(), block.begin() + kBlockHeaderSize);
    damaged[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    EXPECT_FALSE(DecodeBlockHeader(HeaderOf(damaged)).has_value()) << "bit " << bit;
  }
}

TEST(BlockTest, AHeaderThatAnnouncesMoreThanAWriterMakesIsNone) {
  for (const bool raw : {false, true}) {
    BlockHeader header;
    (raw ? header.raw_size : header.stored_size) = kMaxRawSize + 1;
    std::array<std::byte, kBlockHeaderSize> bytes{};
    EncodeBlockHeader(header, bytes);
    EXPECT_FALSE(DecodeBlockHeader(bytes).has_value()) << raw;
    (raw ? header.raw_size : header.stored_size) = kMaxRawSize;
    EncodeBlockHeader(header, bytes);
    EXPECT_TRUE(DecodeBlockHeader(bytes).has_value()) << raw;
  }
}

TEST(BlockTest, ARecordThatIsTooLargeIsRefusedAndTheOthersStay) {
  BlockBuilder builder;
  ASSERT_TRUE(builder.Add(MakeRecord(0)));
  Record large;
  large.mutable_note()->set_text(std::string(kMaxRecordSize, 'x'));
  EXPECT_FALSE(builder.Add(large));
  EXPECT_EQ(builder.records(), 1U);
  large.mutable_note()->set_text(std::string(kMaxRecordSize - 16, 'x'));
  EXPECT_TRUE(builder.Add(large));
  EXPECT_FALSE(builder.Add(large)) << "the block would be larger than kMaxRawSize";
  EXPECT_EQ(builder.records(), 2U);
  (void)builder.Close();
  EXPECT_TRUE(builder.Add(large));
}

TEST(BlockTest, TimesAreTheSmallestAndTheLargestAndNumbersCount) {
  BlockBuilder builder;
  (void)builder.Header(testing::MakeHeader());
  for (const std::int64_t time_ns : {5, 3, 9, 4}) {
    Record record;
    record.set_time_ns(time_ns);
    ASSERT_TRUE(builder.Add(record));
  }
  auto header = DecodeBlockHeader(HeaderOf(builder.Close()));
  ASSERT_TRUE(header.has_value());
  EXPECT_EQ(header->first_time_ns, 3);
  EXPECT_EQ(header->last_time_ns, 9);
  EXPECT_EQ(header->records, 4U);
  EXPECT_EQ(header->number, 1U);
  Record record;
  record.set_time_ns(20);
  ASSERT_TRUE(builder.Add(record));
  header = DecodeBlockHeader(HeaderOf(builder.Close()));
  ASSERT_TRUE(header.has_value());
  EXPECT_EQ(header->first_time_ns, 20) << "the last block's times are forgotten";
  EXPECT_EQ(header->number, 2U);
}

// The payload by hand: zstd's own decompressor, then a varint and a message.
TEST(BlockTest, ThePayloadIsOneZstdFrameOfMessagesBehindTheirLengths) {
  BlockBuilder builder;
  std::string expected;
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE(builder.Add(MakeRecord(i)));
    const std::string message = MakeRecord(i).SerializeAsString();
    ASSERT_LT(message.size(), 128U) << "one byte of varint";
    expected += static_cast<char>(message.size()) + message;
  }
  const auto block = builder.Close();
  const auto header = DecodeBlockHeader(HeaderOf(block));
  ASSERT_TRUE(header.has_value());
  ASSERT_EQ(header->compression, static_cast<int>(Compression::kZstd));
  EXPECT_EQ(block.size(), kBlockHeaderSize + header->stored_size);
  std::string raw(header->raw_size, '\0');
  ASSERT_EQ(
      ZSTD_decompress(raw.data(), raw.size(), block.data() + kBlockHeaderSize, header->stored_size),
      raw.size());
  EXPECT_EQ(raw, expected);
}

TEST(BlockTest, IncompressibleDataIsStoredUnchanged) {
  BlockBuilder builder;
  Record record;
  record.mutable_note()->set_text("x");
  ASSERT_TRUE(builder.Add(record));
  const auto block = builder.Close();
  const auto header = DecodeBlockHeader(HeaderOf(block));
  ASSERT_TRUE(header.has_value());
  EXPECT_EQ(header->compression, static_cast<int>(Compression::kNone));
  EXPECT_EQ(header->stored_size, header->raw_size);
}

TEST(BlockTest, AHeaderTooLargeLosesItsConfigurationAlone) {
  BlockBuilder builder;
  FileHeader header = testing::MakeHeader();
  header.set_config(std::string(kMaxRecordSize, '#'));
  const auto block = builder.Header(header);
  const auto about = DecodeBlockHeader(HeaderOf(block));
  ASSERT_TRUE(about.has_value());
  EXPECT_EQ(about->records, 1U);
  EXPECT_LT(about->raw_size, 1000U);
  EXPECT_GT(about->raw_size, 10U);
}

}  // namespace
}  // namespace styled::recording
