#include "proto/rigs/rokoko/lz4.h"

#include <gtest/gtest.h>
#include <lz4frame.h>

#include <random>
#include <string>
#include <vector>

#include "proto/rigs/rokoko/rokoko.h"
#include "tests/support/count_new.h"
#include "tests/unit/rokoko/lz4_frames.h"
#include "tests/unit/rokoko/texts.h"

namespace styled::rokoko {
namespace {

using Bytes = std::vector<std::byte>;
using Result = Lz4Unpacker::Result;

Bytes ToBytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// By the library itself, in one go: independent of our use of contexts.
Bytes PackedBy(const std::string& text, LZ4F_blockSizeID_t block, LZ4F_blockMode_t mode) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.blockSizeID = block;
  preferences.frameInfo.blockMode = mode;
  preferences.frameInfo.blockChecksumFlag = LZ4F_blockChecksumEnabled;
  Bytes out(LZ4F_compressFrameBound(text.size(), &preferences));
  out.resize(LZ4F_compressFrame(out.data(), out.size(), text.data(), text.size(), &preferences));
  return out;
}

std::string Unpacked(Lz4Unpacker& unpacker, std::span<const std::byte> packed) {
  std::string text(kMaxTextSize, '\0');
  std::size_t size = 0;
  const Result result = unpacker.Unpack(packed, std::as_writable_bytes(std::span(text)), size);
  return result == Result::kOk ? text.substr(0, size) : "refused";
}

TEST(Lz4Unpacker, ReadsWhatTheLz4CommandWrote) {
  Lz4Unpacker unpacker;
  EXPECT_EQ(Unpacked(unpacker, std::as_bytes(std::span(testing::kLz4Default))), testing::kLz4Text);
  EXPECT_EQ(Unpacked(unpacker, std::as_bytes(std::span(testing::kLz4BlockChecksums))),
            testing::kLz4Text);
}

TEST(Lz4Unpacker, ReadsFramesOfAnyBlocks) {
  Lz4Unpacker unpacker;
  std::mt19937 random(5);
  std::string text;
  while (text.size() < kMaxTextSize) text += std::to_string(random() % 100000) + " and so on, ";
  text.resize(kMaxTextSize);
  for (const auto block : {LZ4F_max64KB, LZ4F_max256KB, LZ4F_max1MB, LZ4F_max4MB}) {
    for (const auto mode : {LZ4F_blockLinked, LZ4F_blockIndependent}) {
      EXPECT_TRUE(Unpacked(unpacker, PackedBy(text, block, mode)) == text) << block << mode;
      EXPECT_EQ(Unpacked(unpacker, PackedBy("", block, mode)), "");
    }
  }
}

TEST(Lz4Unpacker, RefusesAFrameThatHoldsMore) {
  Lz4Unpacker unpacker;
  for (const auto block : {LZ4F_max64KB, LZ4F_max4MB}) {
    const Bytes bomb = PackedBy(std::string(64 * kMaxTextSize, ' '), block, LZ4F_blockLinked);
    std::string out(kMaxTextSize, '\0');
    std::size_t size = 0;
    EXPECT_EQ(unpacker.Unpack(bomb, std::as_writable_bytes(std::span(out)), size),
              Result::kTooLong);
    const Bytes one_more = PackedBy(std::string(kMaxTextSize + 1, ' '), block, LZ4F_blockLinked);
    EXPECT_EQ(unpacker.Unpack(one_more, std::as_writable_bytes(std::span(out)), size),
              Result::kTooLong);
    const Bytes just = PackedBy(std::string(kMaxTextSize, ' '), block, LZ4F_blockLinked);
    EXPECT_EQ(unpacker.Unpack(just, std::as_writable_bytes(std::span(out)), size), Result::kOk);
  }
}

TEST(Lz4Unpacker, RefusesDamageAndReadsTheNextFrameAfterIt) {
  Lz4Unpacker unpacker;
  const auto good = std::as_bytes(std::span(testing::kLz4Default));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_EQ(Unpacked(unpacker, good.first(size)), "refused") << size;
  }
  int unseen = 0;
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Bytes bad(good.begin(), good.end());
    bad[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    const std::string text = Unpacked(unpacker, bad);
    unseen += text == testing::kLz4Text ? 1 : 0;
    EXPECT_TRUE(text == "refused" || text == testing::kLz4Text) << bit;
  }
  EXPECT_EQ(unseen, 4) << "bits of the last token that mean nothing";
  Bytes longer(good.begin(), good.end());
  longer.push_back(std::byte{0});
  EXPECT_EQ(Unpacked(unpacker, longer), "refused");
  EXPECT_EQ(Unpacked(unpacker, good), testing::kLz4Text);
}

TEST(Lz4Unpacker, AllocatesNothingWhateverTheFrameAsksFor) {
  Lz4Unpacker unpacker;
  std::string text(kMaxTextSize, 'x');
  std::vector<Bytes> frames;
  for (const auto block : {LZ4F_max64KB, LZ4F_max256KB, LZ4F_max1MB, LZ4F_max4MB}) {
    frames.push_back(PackedBy(text, block, LZ4F_blockIndependent));
    frames.push_back(PackedBy(text, block, LZ4F_blockLinked));
  }
  std::size_t size = 0;
  const support::CountNew count;
  for (const Bytes& frame : frames) {
    ASSERT_EQ(unpacker.Unpack(frame, std::as_writable_bytes(std::span(text)), size), Result::kOk);
  }
  EXPECT_EQ(count.calls(), 0);
}

TEST(Lz4Unpacker, WithoutTheFirstHeadersMemoryWouldAllocate) {
  LZ4F_dctx* cold = nullptr;
  ASSERT_EQ(LZ4F_createDecompressionContext(&cold, LZ4F_VERSION), 0U);
  const Bytes frame = PackedBy("cold", LZ4F_max4MB, LZ4F_blockLinked);
  std::string out(100, '\0');
  std::size_t given = out.size();
  std::size_t taken = frame.size();
  int calls = 0;
  {
    const support::CountNew count;
    (void)LZ4F_decompress(cold, out.data(), &given, frame.data(), &taken, nullptr);
    calls = count.calls();
  }
  LZ4F_freeDecompressionContext(cold);
  if (!support::CountNew::CountsMalloc()) GTEST_SKIP() << "malloc is a sanitizer's here";
  EXPECT_GT(calls, 0);
}

// The library's own reader, with a context of its own.
std::string UnpackedByLibrary(const Bytes& packed) {
  LZ4F_dctx* context = nullptr;
  EXPECT_EQ(LZ4F_createDecompressionContext(&context, LZ4F_VERSION), 0U);
  std::string text(2 * kMaxTextSize, '\0');
  std::size_t given = text.size();
  std::size_t taken = packed.size();
  const std::size_t wanted =
      LZ4F_decompress(context, text.data(), &given, packed.data(), &taken, nullptr);
  LZ4F_freeDecompressionContext(context);
  return wanted == 0 && taken == packed.size() ? text.substr(0, given) : "refused";
}

TEST(Lz4Packer, WritesWhatTheLibraryReads) {
  Lz4Packer packer;
  std::mt19937 random(5);
  std::string noise(100000, '\0');
  for (char& c : noise) c = static_cast<char>(random());
  for (const std::string& text :
       {std::string(), std::string(testing::kLayout3), noise, std::string(kMaxTextSize, 'x')}) {
    Bytes out(kMaxTextSize);
    const std::size_t size = packer.Pack(ToBytes(text), out);
    ASSERT_GT(size, 0U);
    out.resize(size);
    EXPECT_TRUE(IsLz4Frame(out));
    EXPECT_TRUE(UnpackedByLibrary(out) == text);
  }
}

TEST(Lz4Packer, WritesNothingWhereThereIsNoRoom) {
  Lz4Packer packer;
  Bytes out(40, std::byte{9});
  EXPECT_EQ(packer.Pack(ToBytes(testing::kLayout3), out), 0U);
  EXPECT_EQ(out, Bytes(40, std::byte{9}));
  EXPECT_EQ(packer.Pack(Bytes(kMaxTextSize + 1), out), 0U);
}

}  // namespace
}  // namespace styled::rokoko
