#include "daemon/source/face.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "proto/arkit/shapes.h"
#include "proto/styled/face.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::source {
namespace {

using Bytes = std::vector<std::byte>;

Bytes Encoded(const Face& face) {
  Bytes bytes(kMaxFace);
  bytes.resize(EncodeFace(face, bytes));
  return bytes;
}

Bytes MirrorOf(std::span<const std::byte> face) {
  Bytes bytes(kMaxFace);
  bytes.resize(MirrorFace(face, bytes));
  return bytes;
}

v1::SourceFrame Parsed(std::span<const std::byte> face) {
  v1::SourceFrame frame;
  EXPECT_TRUE(frame.ParseFromArray(face.data(), static_cast<int>(face.size())));
  return frame;
}

std::string Mirrored(std::string_view name) {
  Face face;
  face.expressions.push_back({name, 0.25F});
  const v1::SourceFrame frame = Parsed(MirrorOf(Encoded(face)));
  if (frame.expressions_size() != 1) return "not one expression";
  EXPECT_EQ(frame.expressions(0).value(), 0.25F) << name;
  return frame.expressions(0).name();
}

TEST(MirrorFace, SidesOfAllConventionsAreExchanged) {
  const std::vector<std::pair<std::string, std::string>> pairs{
      {"eyeBlinkLeft", "eyeBlinkRight"},  // ARKit
      {"EyeBlinkLeft", "EyeBlinkRight"},  // Live Link Face
      {"mouthLeft", "mouthRight"},
      {"jawLeft", "jawRight"},
      {"eyeLookInLeft", "eyeLookInRight"},
      {"blinkLeft", "blinkRight"},  // VRM 1.0
      {"lookLeft", "lookRight"},
      {"Blink_L", "Blink_R"},  // VRM 0 and VMC
      {"LookLeft", "LookRight"},
      {"LOOKLEFT_LEFT", "LOOKLEFT_RIGHT"},
      {"leftEye", "rightEye"},
      {"LeftEyeClose", "RightEyeClose"},
      {"mouth_left", "mouth_right"},
      {"brow.L.up", "brow.R.up"},
      {"L-brow", "R-brow"},
      {"smile_l", "smile_r"},
      {"left.mouthLeft_L", "right.mouthRight_R"},
      {"Left", "Right"},
      {"あ_L", "あ_R"},
  };
  for (const auto& [left, right] : pairs) {
    EXPECT_EQ(Mirrored(left), right);
    EXPECT_EQ(Mirrored(right), left);
  }
}

TEST(MirrorFace, NamesWithoutASideStay) {
  for (const char* const name :
       {"jawOpen",        "Joy",        "A",     "L",       "R",        "",
        "bright",         "Brightness", "cleft", "upright", "Leftover", "BRIGHT",
        "lower",          "Lip",        "v_rr",  "LR",      "_",        "tongueOut",
        "mouthRollLower", "あ"}) {
    EXPECT_EQ(Mirrored(name), name);
  }
}

TEST(MirrorFace, ArkitsShapesAreExchangedAmongThemselves) {
  Face face;
  for (std::size_t i = 0; i < arkit::kShapes; ++i) {
    face.expressions.push_back({arkit::kNames[i], 0.01F * static_cast<float>(i)});
  }
  const Bytes bytes = Encoded(face);
  const v1::SourceFrame frame = Parsed(MirrorOf(bytes));
  ASSERT_EQ(frame.expressions_size(), static_cast<int>(arkit::kShapes));
  int exchanged = 0;
  for (std::size_t i = 0; i < arkit::kShapes; ++i) {
    const v1::Expression& mirrored = frame.expressions(static_cast<int>(i));
    EXPECT_EQ(mirrored.value(), face.expressions[i].value);
    EXPECT_NE(std::find(arkit::kNames.begin(), arkit::kNames.end(), mirrored.name()),
              arkit::kNames.end())
        << mirrored.name();
    exchanged += mirrored.name() != arkit::kNames[i] ? 1 : 0;
  }
  EXPECT_EQ(exchanged, 40) << "12 of the 52 have no side";
  EXPECT_EQ(MirrorOf(MirrorOf(bytes)), bytes);
}

TEST(MirrorFace, MessagesThatArePassedOnStayByteForByte) {
  const std::string message = "/VMC/Thru/eyeLeft";
  Face face;
  face.expressions = {{"Blink_L", 1}, {"", 0.5F}, {"jawLeft", 0}};
  face.thru.push_back(std::as_bytes(std::span(message)));
  const Bytes mirrored = MirrorOf(Encoded(face));
  const v1::SourceFrame frame = Parsed(mirrored);
  ASSERT_EQ(frame.expressions_size(), 3);
  EXPECT_EQ(frame.expressions(0).name(), "Blink_R");
  EXPECT_EQ(frame.expressions(1).name(), "");
  EXPECT_EQ(frame.expressions(1).value(), 0.5F);
  EXPECT_EQ(frame.expressions(2).name(), "jawRight");
  ASSERT_EQ(frame.thru_size(), 1);
  EXPECT_EQ(frame.thru(0), message);
}

// Other encoders may write the value first, or a name whose length takes two bytes.
TEST(MirrorFace, TheOrderOfFieldsAndLongNamesDoNotMatter) {
  const Bytes value_first{std::byte{0x92}, std::byte{0x01}, std::byte{11},  std::byte{0x15},
                          std::byte{0},    std::byte{0},    std::byte{0},   std::byte{0x3F},
                          std::byte{0x0A}, std::byte{4},    std::byte{'L'}, std::byte{'e'},
                          std::byte{'f'},  std::byte{'t'}};
  const v1::SourceFrame frame = Parsed(MirrorOf(value_first));
  ASSERT_EQ(frame.expressions_size(), 1);
  EXPECT_EQ(frame.expressions(0).name(), "Right");
  EXPECT_EQ(frame.expressions(0).value(), 0.5F);
  // With Right the name has 128 bytes, with Left 127: the length of a length changes, too.
  const std::string longest(123, 'x');
  EXPECT_EQ(Mirrored(longest + "Left"), longest + "Right");
  EXPECT_EQ(Mirrored(longest + "Right"), longest + "Left");
}

TEST(MirrorFace, BytesThatAreNotAFaceAreKept) {
  Face face;
  face.expressions = {{"Blink_L", 0.5F}, {"Blink_R", 0.25F}};
  const Bytes whole = Encoded(face);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const Bytes mirrored = MirrorOf(cut);
    EXPECT_EQ(mirrored.size(), size);
    EXPECT_EQ(MirrorOf(mirrored), cut) << size;
  }
  const Bytes absurd(40, std::byte{0xFF});
  EXPECT_EQ(MirrorOf(absurd), absurd);
  // An expression whose inside is not a message: a name beyond its end.
  const Bytes broken{std::byte{0x92}, std::byte{0x01}, std::byte{3},
                     std::byte{0x0A}, std::byte{9},    std::byte{'L'}};
  EXPECT_EQ(MirrorOf(broken), broken);
}

TEST(MirrorFace, AFaceThatGrowsTooLargeIsLeftOut) {
  Face face;
  face.expressions = {{"jawLeft", 0.5F}};
  const Bytes bytes = Encoded(face);
  Bytes to(bytes.size());
  EXPECT_EQ(MirrorFace(bytes, to), 0U) << "jawRight is longer";
  to.resize(bytes.size() + 1);
  EXPECT_EQ(MirrorFace(bytes, to), bytes.size() + 1);
}

}  // namespace
}  // namespace styled::source
