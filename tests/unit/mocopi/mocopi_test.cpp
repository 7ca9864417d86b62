#include "proto/rigs/mocopi/mocopi.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/mocopi/decode_cases.h"
#include "tests/unit/mocopi/recording.h"

namespace styled::mocopi {
namespace {

using testing::Bytes;

TEST(Mocopi, EveryCaseOfTheTableGivesItsReason) {
  for (const testing::DecodeCase& c : testing::DecodeCases()) {
    Datagram datagram;
    EXPECT_EQ(Name(Decode(c.bytes, datagram)), Name(c.expected)) << c.name;
  }
}

TEST(Mocopi, EveryReasonIsReachedByTheTable) {
  const auto cases = testing::DecodeCases();
  for (int reason = 0; reason < static_cast<int>(DecodeResult::kCount); ++reason) {
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [reason](const auto& c) {
      return static_cast<int>(c.expected) == reason;
    })) << Name(DecodeResult(reason));
  }
}

TEST(Mocopi, CutAnywhereIsRefused) {
  for (const Bytes& good : {testing::GoodFrame(), testing::GoodSkeleton()}) {
    for (std::size_t size = 0; size < good.size(); ++size) {
      Datagram datagram;
      ASSERT_NE(Decode(std::span(good).first(size), datagram), DecodeResult::kOk) << size;
    }
  }
}

TEST(Mocopi, AFrameHandPutTogetherIsReadInEveryField) {
  Datagram datagram;
  datagram.frame.timecode.emplace();  // of the frame before
  ASSERT_EQ(Decode(testing::GoodFrame(), datagram), DecodeResult::kOk);
  ASSERT_EQ(datagram.kind, Datagram::Kind::kFrame);
  EXPECT_EQ(datagram.sender.port, 12351);
  EXPECT_EQ(datagram.sender.address[7], std::byte{'8'});
  EXPECT_EQ(datagram.frame.number, 7U);
  EXPECT_EQ(datagram.frame.time_s, 0.25F);
  EXPECT_EQ(datagram.frame.unix_time_s, 1703810998.5);
  EXPECT_FALSE(datagram.frame.timecode);
  for (std::size_t id = 0; id < kBones; ++id) {
    const Transform& bone = datagram.frame.bones[id];
    EXPECT_EQ(bone.rotation, (std::array<float, 4>{-0.0F, 0.0F, -0.0F, -1.0F}));
    EXPECT_EQ(bone.position_m, (std::array<float, 3>{static_cast<float>(id), 1.0F, 2.0F}));
  }
}

TEST(Mocopi, ASkeletonHandPutTogetherIsReadInEveryField) {
  Datagram datagram;
  ASSERT_EQ(Decode(testing::GoodSkeleton(), datagram), DecodeResult::kOk);
  ASSERT_EQ(datagram.kind, Datagram::Kind::kSkeleton);
  for (std::size_t id = 0; id < kBones; ++id) {
    EXPECT_EQ(datagram.skeleton[id].parent, testing::kParents[id]);
    EXPECT_EQ(datagram.skeleton[id].rest.position_m[0], static_cast<float>(id));
    EXPECT_EQ(kBoneTable[id].parent, testing::kParents[id]);
  }
}

// Encoded bytes must be those of the grammar, which the table puts together without our encoder.
TEST(Mocopi, IsWrittenAsTheGrammarSays) {
  Datagram datagram;
  Bytes out(kFrameSizeWithTimecode);
  ASSERT_EQ(Decode(testing::GoodFrame(), datagram), DecodeResult::kOk);
  ASSERT_EQ(Encode(datagram.sender, datagram.frame, out), kFrameSize);
  EXPECT_TRUE(std::ranges::equal(std::span(out).first(kFrameSize), testing::GoodFrame()));

  const Bytes with_timecode =
      testing::FrameOf(testing::Join({testing::Fnum(), testing::Time(), testing::Uttm(),
                                      testing::Tmcd(), testing::Chunk("btrs", testing::Bones())}));
  ASSERT_EQ(Decode(with_timecode, datagram), DecodeResult::kOk);
  ASSERT_EQ(Encode(datagram.sender, datagram.frame, out), kFrameSizeWithTimecode);
  EXPECT_EQ(out, with_timecode);

  const Bytes early = testing::FrameOf(
      testing::Join({testing::Fnum(), testing::Time(), testing::Chunk("btrs", testing::Bones())}));
  ASSERT_EQ(Decode(early, datagram), DecodeResult::kOk);
  ASSERT_EQ(Encode(datagram.sender, datagram.frame, out), early.size());
  EXPECT_TRUE(std::ranges::equal(std::span(out).first(early.size()), early));

  ASSERT_EQ(Decode(testing::GoodSkeleton(), datagram), DecodeResult::kOk);
  Bytes skeleton(kSkeletonSize);
  ASSERT_EQ(Encode(datagram.sender, datagram.skeleton, skeleton), kSkeletonSize);
  EXPECT_EQ(skeleton, testing::GoodSkeleton());
}

TEST(Mocopi, IsNotWrittenWhereItDoesNotFit) {
  Frame frame;
  frame.unix_time_s = 1;
  frame.timecode.emplace();
  Bytes out(kFrameSizeWithTimecode - 1, std::byte{9});
  const Bytes untouched = out;
  EXPECT_EQ(Encode({}, frame, out), 0U);
  frame.timecode.reset();
  EXPECT_EQ(Encode({}, frame, std::span(out).first(kFrameSize - 1)), 0U);
  EXPECT_EQ(out, untouched);
  Bytes small(kSkeletonSize - 1, std::byte{9});
  EXPECT_EQ(Encode({}, UsualSkeleton(), small), 0U);
  EXPECT_EQ(small, Bytes(kSkeletonSize - 1, std::byte{9}));
}

TEST(MocopiRecording, FrameIsReadAndWrittenByteForByte) {
  const Bytes real = testing::ReadRecording("mocopi_sample_fram.bin", STYLED_DATA_DEFAULT);
  if (real.empty()) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  ASSERT_EQ(real.size(), kFrameSize);
  Datagram datagram;
  ASSERT_EQ(Decode(real, datagram), DecodeResult::kOk);
  ASSERT_EQ(datagram.kind, Datagram::Kind::kFrame);
  EXPECT_EQ(datagram.sender.port, 12351);
  EXPECT_EQ(datagram.frame.number, 1U);
  EXPECT_EQ(datagram.frame.time_s, 0.0F);
  EXPECT_NEAR(datagram.frame.unix_time_s.value_or(0), 1703810998.551346, 1e-6);
  EXPECT_FALSE(datagram.frame.timecode);
  EXPECT_EQ(datagram.frame.bones[0].rotation, (std::array<float, 4>{-0.0F, 0.0F, -0.0F, -1.0F}));
  EXPECT_NEAR(datagram.frame.bones[0].position_m[1], 0.93293, 5e-6);
  Bytes again(kFrameSize);
  ASSERT_EQ(Encode(datagram.sender, datagram.frame, again), kFrameSize);
  EXPECT_EQ(again, real);
}

TEST(MocopiRecording, SkeletonIsReadAndWrittenByteForByteAndIsTheBuiltInOne) {
  const Bytes real = testing::ReadRecording("mocopi_sample_skdf.bin", STYLED_DATA_DEFAULT);
  if (real.empty()) GTEST_SKIP() << "skipped, no data (set STYLED_DATA)";
  ASSERT_EQ(real.size(), kSkeletonSize);
  Datagram datagram;
  ASSERT_EQ(Decode(real, datagram), DecodeResult::kOk);
  ASSERT_EQ(datagram.kind, Datagram::Kind::kSkeleton);
  const Skeleton usual = UsualSkeleton();
  for (std::size_t id = 0; id < kBones; ++id) {
    EXPECT_EQ(datagram.skeleton[id].parent, usual[id].parent) << kBoneTable[id].name;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(datagram.skeleton[id].rest.position_m[axis], usual[id].rest.position_m[axis],
                  5.1e-6)
          << kBoneTable[id].name;
    }
  }
  Bytes again(kSkeletonSize);
  ASSERT_EQ(Encode(datagram.sender, datagram.skeleton, again), kSkeletonSize);
  EXPECT_EQ(again, real);
}

}  // namespace
}  // namespace styled::mocopi
