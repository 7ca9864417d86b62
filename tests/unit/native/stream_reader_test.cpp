#include "proto/rigs/native/stream_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/native/decode_cases.h"

namespace styled::native {
namespace {

using testing::Bytes;
using Result = StreamReader::Result;

// Feeds `stream` in pieces of at most `piece` bytes; collects the records until the stream ends
// or breaks.
Result Feed(StreamReader& reader, const Bytes& stream, std::size_t piece,
            std::vector<Bytes>& records) {
  std::size_t at = 0;
  while (true) {
    std::span<const std::byte> record;
    Result result = reader.Next(record);
    for (; result == Result::kRecord; result = reader.Next(record)) {
      records.emplace_back(record.begin(), record.end());
    }
    if (result == Result::kBroken || at == stream.size()) return result;
    const auto space = reader.Space();
    const std::size_t size = std::min({piece, stream.size() - at, space.size()});
    EXPECT_GT(size, 0U);
    std::copy_n(stream.begin() + static_cast<std::ptrdiff_t>(at), size, space.begin());
    reader.Received(size);
    at += size;
  }
}

Bytes Concatenate(const std::vector<Bytes>& records) {
  Bytes stream;
  for (const Bytes& record : records) stream.insert(stream.end(), record.begin(), record.end());
  return stream;
}

std::vector<Bytes> SomeRecords(std::uint32_t seed, std::size_t largest) {
  std::mt19937 random(seed);
  std::vector<Bytes> records;
  for (std::uint64_t i = 0; i < 60; ++i) {
    records.push_back(
        testing::MakeDatagram(Kind::kSourceFrame, 1, i, Bytes(random() % (largest + 1))));
  }
  return records;
}

TEST(StreamReader, ReturnsWhatWasSentHoweverItIsCut) {
  for (const std::size_t largest : {std::size_t{0}, std::size_t{600}, kMaxPayloadSize}) {
    const auto sent = SomeRecords(7, largest);
    for (const std::size_t piece :
         {std::size_t{1}, std::size_t{31}, std::size_t{1460}, std::size_t{1} << 20}) {
      if (largest == kMaxPayloadSize && piece == 1) continue;
      for (const std::size_t room : {kMaxDatagramSize, 2 * kMaxDatagramSize}) {
        Bytes buffer(room);
        StreamReader reader(buffer);
        std::vector<Bytes> received;
        EXPECT_EQ(Feed(reader, Concatenate(sent), piece, received), Result::kNeedMore);
        EXPECT_EQ(received, sent) << largest << " " << piece << " " << room;
        EXPECT_EQ(reader.Pending(), 0U);
      }
    }
  }
}

TEST(StreamReader, ARecordCutShortIsReported) {
  const Bytes record = testing::MakeDatagram(Kind::kBody, 1, 0, testing::ToBytes("abcdef"));
  Bytes buffer(kMaxDatagramSize);
  StreamReader reader(buffer);
  std::vector<Bytes> received;
  EXPECT_EQ(Feed(reader, Bytes(record.begin(), record.end() - 2), 100, received),
            Result::kNeedMore);
  EXPECT_TRUE(received.empty());
  EXPECT_EQ(reader.Pending(), record.size() - 2);
}

TEST(StreamReader, HandsOutARecordWithAWrongChecksumAndGoesOn) {
  auto sent = SomeRecords(3, 100);
  sent[5].back() ^= std::byte{1};
  Bytes buffer(kMaxDatagramSize);
  StreamReader reader(buffer);
  std::vector<Bytes> received;
  EXPECT_EQ(Feed(reader, Concatenate(sent), 77, received), Result::kNeedMore);
  EXPECT_EQ(received, sent);
}

TEST(StreamReader, StaysBrokenAfterALongerRecordThanAllowed) {
  for (const std::uint32_t length : {std::uint32_t{kMaxPayloadSize + 1}, ~0U}) {
    Bytes bad = testing::MakeDatagram(Kind::kBody, 1, 0, {});
    header::Write<std::uint32_t>(bad, header::kLength, length);
    const Bytes good = testing::MakeDatagram(Kind::kBody, 1, 0, {});
    Bytes buffer(kMaxDatagramSize);
    StreamReader reader(buffer);
    std::vector<Bytes> received;
    EXPECT_EQ(Feed(reader, Concatenate({good, bad, good}), 8, received), Result::kBroken);
    EXPECT_EQ(received.size(), 1U);
    EXPECT_EQ(Name(reader.Broken()), "too_long");
    std::span<const std::byte> record;
    EXPECT_EQ(reader.Next(record), Result::kBroken);
  }
}

TEST(StreamReader, IsBrokenByWhatIsNotOurProtocolAtItsFirstBytes) {
  for (const std::string_view text : {"G", "GET / HTTP/1.1\r\n\r\n", "ST", "STYL", "styd"}) {
    Bytes buffer(kMaxDatagramSize);
    StreamReader reader(buffer);
    std::vector<Bytes> received;
    const Result expected = text == "ST" ? Result::kNeedMore : Result::kBroken;
    EXPECT_EQ(Feed(reader, testing::ToBytes(text), 1, received), expected) << text;
    EXPECT_EQ(Name(reader.Broken()), text == "ST" ? "ok" : "bad_magic");
  }
}

TEST(StreamReader, IsBrokenByAnotherVersion) {
  Bytes bad = testing::MakeDatagram(Kind::kBody, 1, 0, {});
  bad[header::kVersion] = std::byte{2};
  Bytes buffer(kMaxDatagramSize);
  StreamReader reader(buffer);
  std::vector<Bytes> received;
  EXPECT_EQ(Feed(reader, bad, 100, received), Result::kBroken);
  EXPECT_EQ(Name(reader.Broken()), "bad_version");
}

}  // namespace
}  // namespace styled::native
