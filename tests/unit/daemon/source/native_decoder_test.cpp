#include "daemon/source/native_decoder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "daemon/source/face.h"
#include "model/base/text.h"
#include "proto/styled/v1/frame.pb.h"
#include "tests/support/rig.h"

namespace styled::source {
namespace {

std::span<const std::byte> AsBytes(const std::string& text) {
  return std::as_bytes(std::span(text));
}

template <typename Repeated>
bool SameBits(std::span<const std::byte> view, const Repeated& floats) {
  return view.size() == floats.size() * sizeof(float) &&
         std::memcmp(view.data(), floats.data(), view.size()) == 0;
}

TEST(NativeDecoderTest, ReadsWhatProtobufWrote) {
  support::Rig rig("a-b_9");
  v1::SourceFrame frame = rig.MakeFrame();
  frame.set_body_crc(0xDEADBEEF);
  frame.mutable_timecode()->set_hours(23);
  frame.mutable_timecode()->set_minutes(59);
  frame.mutable_timecode()->set_seconds(58);
  frame.mutable_timecode()->set_frames(29);
  frame.mutable_timecode()->set_rate(29.97F);
  frame.mutable_timecode()->set_drop_frame(true);
  const std::string bytes = frame.SerializeAsString();
  SourceFrame view;
  ASSERT_EQ(ReadSourceFrame(AsBytes(bytes), view), FrameResult::kOk);
  EXPECT_EQ(view.performer, "a-b_9");
  EXPECT_EQ(view.source_time_ns, frame.source_time_ns());
  EXPECT_EQ(view.body_crc, 0xDEADBEEF);
  EXPECT_TRUE(SameBits(view.root_position, frame.root_position()));
  EXPECT_TRUE(SameBits(view.rotations, frame.rotations()));
  ASSERT_TRUE(view.has_timecode);
  EXPECT_EQ(view.timecode.hours, 23U);
  EXPECT_EQ(view.timecode.minutes, 59U);
  EXPECT_EQ(view.timecode.seconds, 58U);
  EXPECT_EQ(view.timecode.frames, 29U);
  EXPECT_EQ(view.timecode.rate, 29.97F);
  EXPECT_TRUE(view.timecode.drop_frame);
  EXPECT_EQ(ReadPerformer(AsBytes(bytes)), "a-b_9");
}

TEST(NativeDecoderTest, SkipsFieldsOfLaterVersions) {
  std::string bytes = support::Rig("a").MakeFrame().SerializeAsString();
  bytes += std::string("\x38\x96\x01", 3);          // field 7, varint
  bytes += std::string("\x82\x01\x03xyz", 6);       // field 16, bytes
  bytes += std::string("\x41\0\0\0\0\0\0\0\0", 9);  // field 8, fixed64
  SourceFrame view;
  EXPECT_EQ(ReadSourceFrame(AsBytes(bytes), view), FrameResult::kOk);
}

TEST(NativeDecoderTest, TheFaceIsItsRunOfBytesAndAnUnreadableOneIsRefused) {
  v1::SourceFrame frame = support::Rig("a").MakeFrame();
  const auto add = [&frame](const std::string& name, float value) {
    auto& expression = *frame.add_expressions();
    expression.set_name(name);
    expression.set_value(value);
  };
  add("Joy", 0.5F);
  add("あ", 1);
  frame.add_thru("/VMC/Thru/x");
  const std::string bytes = frame.SerializeAsString();
  SourceFrame view;
  ASSERT_EQ(ReadSourceFrame(AsBytes(bytes), view), FrameResult::kOk);
  v1::Frame out;  // the same fields
  ASSERT_TRUE(out.ParseFromArray(view.face.data(), static_cast<int>(view.face.size())));
  ASSERT_EQ(out.expressions_size(), 2);
  EXPECT_EQ(out.expressions(1).name(), "あ");
  EXPECT_EQ(out.thru(0), "/VMC/Thru/x");

  for (const char* broken : {"\xFF", "a\xC0\x80", "\xED\xA0\x80", "\xF5\x80\x80\x80", "\xE3\x81"}) {
    EXPECT_FALSE(IsUtf8(broken)) << broken;
    // A name that is not text, as bytes: field 18, of a field 1.
    std::string bad = support::Rig("a").MakeFrame().SerializeAsString();
    const std::string name = broken;
    bad += std::string("\x92\x01") + static_cast<char>(name.size() + 2) + "\x0A" +
           static_cast<char>(name.size()) + name;
    EXPECT_EQ(ReadSourceFrame(AsBytes(bad), view), FrameResult::kMalformed);
    EXPECT_FALSE(v1::SourceFrame().ParseFromString(bad)) << "nor would protobuf";
  }
  for (const char* good : {"", "jawOpen", "ü", "あ", "\xF0\x9F\x98\x80"}) EXPECT_TRUE(IsUtf8(good));

  for (int i = 0; i < 300; ++i) add(std::string(64, 'x'), 1);
  const std::string large = frame.SerializeAsString();
  ASSERT_EQ(ReadSourceFrame(AsBytes(large), view), FrameResult::kOk);
  EXPECT_TRUE(view.face.empty()) << "too much of it is left out";
}

TEST(NativeDecoderTest, NamesAreCheckedAgainstTheRule) {
  for (const std::string name :
       {"", "with space", "dot.dot", "slash/", "ümlaut", "123456789012345678901234567890123"}) {
    support::Rig rig(name);
    const std::string bytes = rig.MakeFrame().SerializeAsString();
    SourceFrame view;
    EXPECT_EQ(ReadSourceFrame(AsBytes(bytes), view), FrameResult::kBadName) << name;
  }
}

// Where protobuf refuses, so do we; where both read, they read the same.
TEST(NativeDecoderTest, AgreesWithProtobufOnDamagedBytes) {
  v1::SourceFrame whole = support::Rig("a").MakeFrame();
  whole.mutable_timecode()->set_frames(3);
  whole.set_body_crc(9);
  const std::string bytes = whole.SerializeAsString();
  std::mt19937 random(3);
  int read_by_both = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string damaged = bytes;
    if (random() % 3 == 0) damaged.resize(random() % damaged.size());
    for (unsigned k = random() % 3; k > 0 && !damaged.empty(); --k) {
      // Mostly in the fields' heads, where it matters.
      const std::size_t at = random() % 2 == 0
                                 ? random() % damaged.size()
                                 : random() % std::min<std::size_t>(60, damaged.size());
      damaged[at] = static_cast<char>(random());
    }
    SourceFrame view;
    if (ReadSourceFrame(AsBytes(damaged), view) != FrameResult::kOk) continue;
    v1::SourceFrame reference;
    ASSERT_TRUE(reference.ParseFromString(damaged)) << i;
    ++read_by_both;
    ASSERT_EQ(view.performer, reference.performer());
    ASSERT_EQ(view.source_time_ns, reference.source_time_ns());
    ASSERT_EQ(view.body_crc, reference.body_crc());
    ASSERT_EQ(view.has_timecode, reference.has_timecode());
  }
  EXPECT_GT(read_by_both, 1000);
}

TEST(NativeDecoderTest, APoseIsCopiedBitForBitOrNotAtAll) {
  v1::SourceFrame frame = support::Rig("a").MakeFrame();
  frame.set_rotations(5, -0.0F);
  const std::string bytes = frame.SerializeAsString();
  SourceFrame view;
  ASSERT_EQ(ReadSourceFrame(AsBytes(bytes), view), FrameResult::kOk);
  rig::Skeleton skeleton;
  skeleton.names.resize(21);
  skeleton.parents.resize(21);
  skeleton.offsets.assign(21, rig::Vec3(1, 2, 3));
  rig::RigPose pose(skeleton);
  EXPECT_FALSE(CopyPose(view, 20, pose));
  EXPECT_EQ(pose.translations[0], rig::Vec3(1, 2, 3));
  ASSERT_TRUE(CopyPose(view, 21, pose));
  EXPECT_EQ(std::memcmp(pose.rotations.data(), frame.rotations().data(), 84 * sizeof(float)), 0);
  EXPECT_EQ(pose.translations[1], rig::Vec3(1, 2, 3)) << "only the root moves";
}

}  // namespace
}  // namespace styled::source
