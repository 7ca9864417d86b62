#include "proto/rigs/ifacialmocap/ifacialmocap.h"

#include <gtest/gtest.h>

#include "tests/unit/ifacialmocap/texts.h"

namespace styled::ifacialmocap {
namespace {

DecodeResult Read(std::string_view text, Frame& frame) {
  return Decode(std::as_bytes(std::span(text)), frame);
}

TEST(IFacialMocap, RefusesWhatIsNoneAndSaysWhy) {
  for (const auto& c : testing::DecodeCases()) {
    Frame frame;
    EXPECT_EQ(Read(c.text, frame), c.result) << c.name << ": " << Name(Read(c.text, frame));
  }
}

TEST(IFacialMocap, ReadsBothVersions) {
  Frame frame;
  ASSERT_EQ(Read(testing::kVersion1, frame), DecodeResult::kOk);
  EXPECT_EQ(frame.known, 5);
  EXPECT_FLOAT_EQ(frame.shapes[*arkit::Find("eyeLookDownLeft")], 0.17F);
  EXPECT_FLOAT_EQ(frame.shapes[*arkit::Find("jawOpen")], 0.12F);
  EXPECT_FLOAT_EQ(frame.shapes[*arkit::Find("mouthLeft")], 0.01F);
  EXPECT_FLOAT_EQ(frame.head[5], -0.6584072F);
  EXPECT_FLOAT_EQ(frame.right_eye[1], 2.4403017F);
  EXPECT_FLOAT_EQ(frame.left_eye[0], 6.034903F);
  ASSERT_EQ(Read(testing::kVersion2, frame), DecodeResult::kOk);
  EXPECT_EQ(frame.known, 3);
  EXPECT_FLOAT_EQ(frame.shapes[*arkit::Find("jawOpen")], -0.03F) << "as received";
  EXPECT_FLOAT_EQ(frame.shapes[*arkit::Find("mouthSmileRight")], 0.03F);
}

TEST(IFacialMocap, WrittenBytesAreReadAgain) {
  Frame frame;
  for (std::size_t i = 0; i < arkit::kShapes; ++i) {
    frame.shapes[i] = static_cast<float>(i) / 100.0F;
  }
  frame.known = arkit::kShapes;
  frame.head = {1.5F, -2.25F, 3, 0.125F, -0.5F, 0.75F};
  frame.left_eye = {1, -2, 0.5F};
  for (const int version : {1, 2}) {
    std::array<char, kMaxSize> text;
    const std::size_t size = Encode(frame, version, text);
    ASSERT_GT(size, 0U);
    Frame again;
    ASSERT_EQ(Read({text.data(), size}, again), DecodeResult::kOk);
    EXPECT_EQ(again, frame) << std::string_view(text.data(), size);
  }
  std::array<char, 100> small;
  EXPECT_EQ(Encode(frame, 2, small), 0U);
}

}  // namespace
}  // namespace styled::ifacialmocap
