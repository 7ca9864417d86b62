#include "proto/recording/reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "tests/unit/recording/samples.h"

namespace styled::recording {
namespace {

using testing::Append;
using testing::Bytes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MakeRecord;
using testing::MakeSample;
using testing::Sample;

constexpr int kPerBlock = 4;

struct Outcome {
  std::string error;  // of Open
  std::vector<Record> records;
  ReadCounts counts;
  FileHeader header;
};

Outcome ReadAll(Bytes bytes, const ReaderOptions& options = {}) {
  Outcome outcome;
  auto reader = Reader::Open(MemoryInput(std::move(bytes)), "x.styrec", options);
  if (!reader.ok()) {
    outcome.error = reader.status().message();
    return outcome;
  }
  Record record;
  while (reader.value()->Next(record)) outcome.records.push_back(record);
  outcome.counts = reader.value()->counts();
  outcome.header = reader.value()->header();
  return outcome;
}

bool Same(const google::protobuf::MessageLite& a, const google::protobuf::MessageLite& b) {
  return a.SerializeAsString() == b.SerializeAsString();
}

// Whether `records` are MakeRecord(i) for the `numbers`.
void ExpectRecords(const std::vector<Record>& records, const std::vector<int>& numbers) {
  ASSERT_EQ(records.size(), numbers.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    EXPECT_TRUE(Same(records[i], MakeRecord(numbers[i]))) << "record " << i;
  }
}

std::vector<int> Range(int begin, int end) {
  std::vector<int> numbers;
  for (int i = begin; i < end; ++i) numbers.push_back(i);
  return numbers;
}

std::vector<int> Without(int count, int block) {  // all but the records of one block
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) {
    if (i / kPerBlock != block) numbers.push_back(i);
  }
  return numbers;
}

Bytes Insert(Bytes bytes, std::size_t at, const Bytes& more) {
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), more.begin(), more.end());
  return bytes;
}

Bytes Erase(Bytes bytes, std::size_t at, std::size_t count) {
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  bytes.erase(begin, begin + static_cast<std::ptrdiff_t>(count));
  return bytes;
}

TEST(ReaderTest, AMissingFileAFolderAndAFileOfAnotherKindAreRefusedByNameOffsetAndExpectation) {
  EXPECT_THAT(Reader::Open("/nonexistent/x.styrec").status().message(),
              HasSubstr("/nonexistent/x.styrec: cannot be read"));
  EXPECT_THAT(Reader::Open("/tmp").status().message(), HasSubstr("expected a recording"));
  Bytes bytes(100, std::byte{'{'});
  EXPECT_EQ(ReadAll(bytes).error,
            "x.styrec: offset 0: found 7B 7B 7B 7B 7B 7B 7B 7B, expected a recording's first "
            "bytes, 89 53 54 59 52 0D 0A 1A");
  EXPECT_THAT(ReadAll({}).error, HasSubstr("offset 0: found the end"));
}

TEST(ReaderTest, AnyBitOfTheMagicFlippedIsRefused) {
  for (std::size_t bit = 0; bit < 8 * kFileMagic.size(); ++bit) {
    Bytes bytes = MakeSample().bytes;
    bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    EXPECT_THAT(ReadAll(bytes).error, HasSubstr("offset 0")) << bit;
  }
}

TEST(ReaderTest, AnotherVersionIsRefused) {
  Bytes bytes = MakeSample().bytes;
  bytes[8] = std::byte{2};
  EXPECT_EQ(ReadAll(bytes).error, "x.styrec: offset 8: found version 2, expected 1");
  bytes[8] = std::byte{0};
  EXPECT_EQ(ReadAll(bytes).error, "x.styrec: offset 8: found version 0, expected 1");
}

TEST(ReaderTest, SalvageReadsOnWithoutAPreamble) {
  const Sample sample = MakeSample();
  Bytes bytes = sample.bytes;
  bytes[0] = bytes[8] = std::byte{0};
  const Outcome outcome = ReadAll(bytes, {.salvage = true});
  EXPECT_EQ(outcome.error, "");
  ExpectRecords(outcome.records, Range(0, sample.records));
}

TEST(ReaderTest, AWholeRecordingGivesHeaderAndRecordsAndNoDamage) {
  const Sample sample = MakeSample(5);
  const Outcome outcome = ReadAll(sample.bytes);
  ASSERT_EQ(outcome.error, "");
  EXPECT_TRUE(Same(outcome.header, testing::MakeHeader()));
  ExpectRecords(outcome.records, Range(0, sample.records));
  EXPECT_EQ(outcome.counts.blocks, 6U);
  EXPECT_EQ(outcome.counts.records, 20U);
  EXPECT_EQ(DamageText(outcome.counts), "");
}

// The file as a kill or a full disk leaves it, at every length that it ever had.
TEST(ReaderTest, TruncatedAnywhereTheWholeBlocksAreReadAndTheRestIsATailAndNoDamage) {
  const Sample sample = MakeSample();
  for (std::size_t size = 0; size <= sample.bytes.size(); ++size) {
    const Outcome outcome = ReadAll(Bytes(sample.bytes.begin(), sample.bytes.begin() + size));
    if (size < kPreambleSize) {
      EXPECT_THAT(outcome.error, HasSubstr("offset " + std::to_string(size) + ": found the end"));
      continue;
    }
    ASSERT_EQ(outcome.error, "") << size;
    int whole = 0;  // blocks that are here entirely
    while (sample.blocks[whole + 1] <= size) {
      if (++whole + 1 == static_cast<int>(sample.blocks.size())) break;
    }
    ExpectRecords(outcome.records, Range(0, kPerBlock * std::max(0, whole - 1)));
    EXPECT_EQ(outcome.counts.tail_bytes, size - sample.blocks[whole]) << size;
    EXPECT_EQ(outcome.counts.damaged_places, 0U) << size;
    EXPECT_EQ(outcome.counts.lost_blocks, 0U) << size;
    EXPECT_EQ(outcome.counts.malformed, 0U) << size;
  }
}

TEST(ReaderTest, ABitFlippedAnywhereCostsItsBlockAloneAndIsReported) {
  const Sample sample = MakeSample();
  for (std::size_t at = kPreambleSize; at < sample.bytes.size(); ++at) {
    Bytes bytes = sample.bytes;
    bytes[at] ^= static_cast<std::byte>(1U << (at % 8));
    const Outcome outcome = ReadAll(bytes);
    ASSERT_EQ(outcome.error, "");
    int hit = 0;
    while (sample.blocks[hit + 1] <= at) ++hit;
    const std::size_t block_size = sample.blocks[hit + 1] - sample.blocks[hit];
    ExpectRecords(outcome.records, Without(sample.records, hit - 1));
    EXPECT_EQ(Same(outcome.header, FileHeader()), hit == 0) << at;
    EXPECT_EQ(outcome.counts.skipped_bytes + outcome.counts.tail_bytes, block_size) << at;
    EXPECT_LE(outcome.counts.damaged_places, 1U) << at;
    const bool last = hit + 2 == static_cast<int>(sample.blocks.size());
    if (last) continue;  // nothing behind it tells a missing block
    ASSERT_THAT(outcome.counts.damage, ::testing::SizeIs(1)) << at;
    EXPECT_EQ(outcome.counts.damage[0].offset, sample.blocks[hit]) << at;
    EXPECT_EQ(outcome.counts.damage[0].bytes, block_size) << at;
    EXPECT_EQ(outcome.counts.lost_blocks, 1U) << at;
  }
}

TEST(ReaderTest, BytesPutInBetweenAreSkipped) {
  const Sample sample = MakeSample();
  for (const std::size_t count : {1U, 3U, 47U, 48U, 70'000U}) {
    const Bytes garbage(count, std::byte{0xF5});
    const Outcome outcome = ReadAll(Insert(sample.bytes, sample.blocks[2], garbage));
    ExpectRecords(outcome.records, Range(0, sample.records));
    EXPECT_EQ(outcome.counts.skipped_bytes, count);
    EXPECT_EQ(outcome.counts.lost_blocks, 0U);
  }
}

TEST(ReaderTest, AMagicAcrossTwoStepsOfTheSearchIsFound) {
  const Sample sample = MakeSample();
  for (std::size_t count = 4'080; count < 4'110; ++count) {
    const Outcome outcome =
        ReadAll(Insert(sample.bytes, sample.blocks[2], Bytes(count, std::byte{0x20})));
    ExpectRecords(outcome.records, Range(0, sample.records));
  }
}

TEST(ReaderTest, BytesTakenOutAnywhereCostTheBlocksTheyTouch) {
  const Sample sample = MakeSample();
  for (std::size_t at = sample.blocks[1]; at + 20 < sample.bytes.size(); ++at) {
    const Outcome outcome = ReadAll(Erase(sample.bytes, at, 20));
    std::vector<int> expected;
    for (int i = 0; i < sample.records; ++i) {
      const int block = 1 + i / kPerBlock;
      const bool touched = at < sample.blocks[block + 1] && at + 20 > sample.blocks[block];
      if (!touched) expected.push_back(i);
    }
    ExpectRecords(outcome.records, expected);
  }
}

TEST(ReaderTest, LostBlocksAreCountedByTheirNumbers) {
  const Sample sample = MakeSample(6);
  const Outcome outcome =
      ReadAll(Erase(sample.bytes, sample.blocks[2], sample.blocks[4] - sample.blocks[2]));
  std::vector<int> expected = Range(0, kPerBlock);
  for (const int i : Range(3 * kPerBlock, 6 * kPerBlock)) expected.push_back(i);
  ExpectRecords(outcome.records, expected);
  EXPECT_EQ(outcome.counts.lost_blocks, 2U);
  EXPECT_EQ(outcome.counts.damaged_places, 0U);
  EXPECT_EQ(DamageText(outcome.counts), "2 blocks missing");
}

TEST(ReaderTest, GarbageAtTheEndIsDamageAndZerosAreToo) {
  const Sample sample = MakeSample();
  for (const std::byte byte : {std::byte{0}, std::byte{0xAA}}) {
    Bytes bytes = sample.bytes;
    Append(bytes, Bytes(100, byte));
    const Outcome outcome = ReadAll(bytes);
    ExpectRecords(outcome.records, Range(0, sample.records));
    EXPECT_EQ(outcome.counts.skipped_bytes, 100U);
    EXPECT_EQ(outcome.counts.tail_bytes, 0U);
  }
}

TEST(ReaderTest, DamageBeforeABlockCutShortIsToldFromIt) {
  const Sample sample = MakeSample();
  Bytes bytes = Erase(sample.bytes, sample.bytes.size() - 5, 5);
  bytes = Insert(bytes, sample.blocks[3], Bytes(9, std::byte{1}));
  const Outcome outcome = ReadAll(bytes);
  ExpectRecords(outcome.records, Range(0, 2 * kPerBlock));
  EXPECT_EQ(outcome.counts.skipped_bytes, 9U);
  EXPECT_EQ(outcome.counts.tail_bytes, sample.bytes.size() - 5 - sample.blocks[3]);
}

// A block with false claims, though its checksums are right.
Bytes WithBlock(const Bytes& payload, std::uint8_t type, std::uint8_t compression,
                std::uint32_t raw_size) {
  const Sample sample = MakeSample();
  BlockHeader header;
  header.type = type;
  header.compression = compression;
  header.stored_size = static_cast<std::uint32_t>(payload.size());
  header.raw_size = raw_size;
  header.payload_crc = Checksum(payload);
  header.number = 2;
  Bytes block(kBlockHeaderSize);
  EncodeBlockHeader(header, std::span(block).first<kBlockHeaderSize>());
  Append(block, payload);
  return Insert(sample.bytes, sample.blocks[2], block);
}

TEST(ReaderTest, PayloadsThatLieAreMalformedAndTheOtherBlocksAreRead) {
  const Bytes text = [] {
    Bytes bytes(10);
    std::memcpy(bytes.data(), "0123456789", 10);
    return bytes;
  }();
  const auto expect_malformed = [](const Bytes& bytes, const char* what) {
    const Outcome outcome = ReadAll(bytes);
    EXPECT_EQ(outcome.counts.malformed, 1U) << what;
    ExpectRecords(outcome.records, Range(0, 3 * kPerBlock));
  };
  expect_malformed(WithBlock(text, 2, 1, 100), "no zstd frame");
  expect_malformed(WithBlock(text, 2, 0, 11), "raw size is not stored size");
  expect_malformed(WithBlock(text, 2, 2, 10), "unknown compression");
  expect_malformed(WithBlock(text, 2, 0, 10), "a length beyond the payload");
  expect_malformed(WithBlock(Bytes(10, std::byte{0xFF}), 2, 0, 10), "a varint without an end");
  expect_malformed(WithBlock({std::byte{1}, std::byte{0xFF}}, 2, 0, 2), "no Record");
  // A zstd frame larger than the block says: the records' own block 2 with a smaller raw size.
  BlockBuilder builder;
  for (int i = 0; i < 40; ++i) (void)builder.Add(MakeRecord(i));
  const auto whole = builder.Close();
  const auto payload = whole.subspan(kBlockHeaderSize);
  expect_malformed(WithBlock(Bytes(payload.begin(), payload.end()), 2, 1, 50),
                   "larger than it says");
}

TEST(ReaderTest, ABlockOfALaterProgramIsPassedOver) {
  const Outcome outcome = ReadAll(WithBlock(Bytes(10), 77, 0, 10));
  ExpectRecords(outcome.records, Range(0, 3 * kPerBlock));
  EXPECT_EQ(outcome.counts.unknown_blocks, 1U);
}

TEST(ReaderTest, TwoRecordingsOneBehindTheOtherAreReadAsOneWithItsSeamSkipped) {
  Bytes bytes = MakeSample(1).bytes;
  Append(bytes, MakeSample(1).bytes);
  const Outcome outcome = ReadAll(bytes);
  EXPECT_EQ(outcome.records.size(), 2U * kPerBlock);
  EXPECT_EQ(outcome.counts.skipped_bytes, kPreambleSize);
  EXPECT_EQ(outcome.counts.unknown_blocks, 1U);
}

TEST(ReaderTest, RewindBeginsAnewAndTheTimeRangeComesFromTheBlocks) {
  const Sample sample = MakeSample();
  auto reader = Reader::Open(MemoryInput(sample.bytes), "x");
  ASSERT_TRUE(reader.ok());
  Record record;
  ASSERT_TRUE(reader.value()->Next(record));
  ASSERT_TRUE(reader.value()->Next(record));
  const auto range = reader.value()->FindTimeRange();
  ASSERT_TRUE(range.any);
  EXPECT_EQ(range.first_ns, MakeRecord(0).time_ns());
  EXPECT_EQ(range.last_ns, MakeRecord(sample.records - 1).time_ns());
  ASSERT_TRUE(reader.value()->Next(record));
  EXPECT_TRUE(Same(record, MakeRecord(2))) << "looking at the range moves nothing";
  reader.value()->Rewind();
  ASSERT_TRUE(reader.value()->Next(record));
  EXPECT_TRUE(Same(record, MakeRecord(0)));
  EXPECT_EQ(reader.value()->counts().records, 1U);
  EXPECT_FALSE(Reader::Open(MemoryInput(MakeSample(0).bytes), "x").value()->FindTimeRange().any);
}

TEST(ReaderTest, DamageIsSaidInWords) {
  ReadCounts counts;
  counts.damage = {{96, 400}};
  counts.damaged_places = 2;
  counts.skipped_bytes = 412;
  counts.lost_blocks = 1;
  counts.malformed = 1;
  counts.unknown_blocks = 2;
  counts.tail_bytes = 17;
  EXPECT_EQ(DamageText(counts),
            "412 bytes skipped in 2 places (the first at offset 96), 1 block missing, 1 record "
            "malformed, 2 blocks of an unknown type, the last block is cut short (17 bytes of it "
            "are here)");
}

}  // namespace
}  // namespace styled::recording
