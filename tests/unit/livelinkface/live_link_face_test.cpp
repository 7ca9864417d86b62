#include "proto/rigs/livelinkface/live_link_face.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "proto/arkit/shapes.h"
#include "tests/unit/livelinkface/decode_cases.h"

namespace styled::live_link_face {
namespace {

using testing::Bytes;

TEST(LiveLinkFace, RefusesWhatIsNoneAndSaysWhy) {
  for (const auto& c : testing::DecodeCases()) {
    Frame frame;
    EXPECT_EQ(Decode(c.bytes, frame), c.result) << c.name << ": " << Name(Decode(c.bytes, frame));
  }
}

TEST(LiveLinkFace, ReadsWhatTheLayoutSaysByteForByte) {
  Frame frame;
  const Bytes bytes = testing::ByHand();
  ASSERT_EQ(Decode(bytes, frame), DecodeResult::kOk);
  EXPECT_EQ(frame.device, "A");
  EXPECT_EQ(frame.subject, "B");
  EXPECT_EQ(frame.frame, 258);
  EXPECT_EQ(frame.subframe, 0.5F);
  EXPECT_EQ(frame.rate, 60);
  EXPECT_FALSE(frame.has_face);
  EXPECT_EQ(testing::Written(frame), bytes);
}

TEST(LiveLinkFace, ARecordingOfTheAppIsReadAndWrittenByteForByte) {
  const auto datagrams = testing::ReadRecording("dao.gesichter", STYLED_DATA_DEFAULT);
  if (datagrams.empty()) GTEST_SKIP() << "skipped, no data";
  ASSERT_EQ(datagrams.size(), 180U);
  std::int32_t last = 0;
  for (const Bytes& bytes : datagrams) {
    Frame frame;
    ASSERT_EQ(Decode(bytes, frame), DecodeResult::kOk);
    ASSERT_TRUE(frame.has_face);
    EXPECT_EQ(frame.subject, "LLV Default Device");
    EXPECT_GT(frame.frame, last);
    last = frame.frame;
    EXPECT_EQ(testing::Written(frame), bytes);
  }
  Frame first;
  ASSERT_EQ(Decode(datagrams.front(), first), DecodeResult::kOk);
  EXPECT_EQ(first.frame, 5'375'735);
  EXPECT_FLOAT_EQ(first.subframe, 0.121925354F);
  EXPECT_FLOAT_EQ(first.values[*arkit::Find("eyeLookDownLeft")], 0.164290234F);
  EXPECT_FLOAT_EQ(first.values[*arkit::Find("jawOpen")], 0.077328339F);
  EXPECT_NEAR(first.values[*arkit::Find("tongueOut")], 0.0000357078F, 1e-9F);
}

// In these recordings of LLV exactly one expression moves.
TEST(LiveLinkFace, AnExpressionIsWhereItsNameSays) {
  bool any = false;
  for (const auto* const shape : {"eyeblinkleft", "jawopen"}) {
    const auto datagrams =
        testing::ReadRecording(std::string("debug-") + shape + ".gesichter", STYLED_DATA_DEFAULT);
    any = any || !datagrams.empty();
    float most = 0;
    for (const Bytes& bytes : datagrams) {
      Frame frame;
      ASSERT_EQ(Decode(bytes, frame), DecodeResult::kOk);
      for (std::size_t i = 0; i < kValues; ++i) {
        if (i == arkit::Find(shape)) {
          most = std::max(most, std::abs(frame.values[i]));
        } else {
          EXPECT_EQ(frame.values[i], 0) << shape << ' ' << i;
        }
      }
    }
    if (!datagrams.empty()) {
      EXPECT_GT(most, 0.9F) << shape;
    }
  }
  if (!any) GTEST_SKIP() << "skipped, no data";
}

TEST(LiveLinkFace, AnOverlongPacketIsNotWritten) {
  std::array<std::byte, 100> small;
  EXPECT_EQ(Encode(testing::Smile(), small), 0U);
  const std::string text(kMaxText + 1, 'x');
  Frame frame = testing::Smile();
  frame.subject = text;
  std::array<std::byte, 2000> large;
  EXPECT_EQ(Encode(frame, large), 0U);
}

}  // namespace
}  // namespace styled::live_link_face
