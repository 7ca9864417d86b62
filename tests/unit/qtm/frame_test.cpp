#include "proto/rigs/qtm/frame.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/unit/qtm/decode_cases.h"

namespace styled::qtm {
namespace {

using namespace testing;

DecodeResult Decoded(const Bytes& packet, Frame& frame) {
  return DecodeFrame(std::span(packet).subspan(kHeaderSize), frame);
}

TEST(QtmFrame, IsTakenOrRefusedForItsReason) {
  const auto frame = std::make_unique<Frame>();
  for (const DecodeCase& c : DecodeCases()) {
    EXPECT_EQ(Decoded(c.packet, *frame), c.expected) << c.name;
  }
}

TEST(QtmFrame, HasEveryValue) {
  const auto frame = std::make_unique<Frame>();
  ASSERT_EQ(Decoded(DecodeCases()[0].packet, *frame), DecodeResult::kOk);
  EXPECT_EQ(frame->timestamp_us, 1'234'567);
  EXPECT_EQ(frame->number, 42U);
  ASSERT_TRUE(frame->has_skeletons);
  ASSERT_EQ(frame->skeleton_count, 2U);
  ASSERT_EQ(frame->skeletons[0].segment_count, 2U);
  EXPECT_EQ(frame->skeletons[1].segment_count, 0U) << "not seen";
  const Segment& hips = frame->skeletons[0].segments[0];
  EXPECT_EQ(hips.id, 752U);
  EXPECT_EQ(hips.position_mm, (std::array<float, 3>{100, -200, 950.5F}));
  EXPECT_EQ(hips.rotation, (std::array<float, 4>{0, 0, 0.6F, 0.8F}));
  EXPECT_EQ(frame->skeletons[0].segments[1].id, 753U);
  ASSERT_TRUE(frame->has_timecode);
  const ClockTime time = Unpack(frame->timecode);
  EXPECT_EQ(time.hours, 13U);
  EXPECT_EQ(time.minutes, 45U);
  EXPECT_EQ(time.seconds, 7U);
  EXPECT_EQ(time.parts, 21U);
}

TEST(QtmFrame, LeavesOutWhatIsTooMany) {
  const auto frame = std::make_unique<Frame>();
  ASSERT_EQ(Decoded(DecodeCases()[4].packet, *frame), DecodeResult::kOk);
  EXPECT_EQ(frame->skeleton_count, kMaxSkeletons);
  EXPECT_EQ(frame->skeletons_left_out, 1U);
  Bytes segments;
  for (std::uint32_t s = 0; s <= kMaxSegments; ++s) {
    SegmentOf(s, 0, 0, 0, 0, 0, 0, 1).AppendTo(segments);
  }
  const Bytes large = Data(1, 1,
                           ComponentOf(18, U32{2}, U32{kMaxSegments + 1}, Part{segments}, U32{1},
                                       SegmentOf(9, 1, 2, 3, 0, 0, 0, 1)));
  ASSERT_EQ(Decoded(large, *frame), DecodeResult::kOk);
  ASSERT_EQ(frame->skeleton_count, 2U) << "its place is kept: the order is the XML's";
  EXPECT_EQ(frame->skeletons[0].segment_count, 0U);
  EXPECT_EQ(frame->skeletons[1].segments[0].id, 9U);
}

// Its packet is cut short with a correct size; and its header has the whole size, but components
// end early.
TEST(QtmFrame, CutAnywhereIsRefusedOrHasFewerBytesAfterItsEnd) {
  const auto frame = std::make_unique<Frame>();
  const Bytes whole = DecodeCases()[0].packet;
  for (std::size_t size = kHeaderSize; size < whole.size(); ++size) {
    EXPECT_NE(
        Decoded(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), *frame),
        DecodeResult::kOk)
        << size;
  }
}

TEST(QtmFrame, IrigIsATimeOfDayToo) {
  // Day 32 of year 26; 23:59:58.7.
  const Timecode irig{Timecode::Kind::kIrig, 26 | 32 << 7, 23 | 59 << 5 | 58 << 11 | 7 << 17};
  const ClockTime time = Unpack(irig);
  EXPECT_EQ(time.hours, 23U);
  EXPECT_EQ(time.seconds, 58U);
  EXPECT_EQ(time.parts, 7U);
}

TEST(QtmFrame, WrittenIsByteForByteAsTheProtocolHasIt) {
  const auto frame = std::make_unique<Frame>();
  frame->timestamp_us = 1'234'567;
  frame->number = 42;
  frame->has_markers = frame->has_timecode = frame->has_skeletons = true;
  frame->markers.count = 1;
  frame->markers.positions_mm[0] = {1, -2, 3.5F};
  frame->timecode = PackSmpte({13, 45, 7, 21});
  frame->skeleton_count = 2;
  frame->skeletons[0].segment_count = 2;
  frame->skeletons[0].segments[0] = {752, {100, -200, 950.5F}, {0, 0, 0.6F, 0.8F}};
  frame->skeletons[0].segments[1] = {753, {0, 0, 125}, {0.5F, -0.5F, 0.5F, -0.5F}};
  frame->skeletons[1].segment_count = 0;
  Bytes out(4096);
  out.resize(EncodeFrame(*frame, out));
  EXPECT_EQ(out, Data(1'234'567, 42, ComponentOf(1, U32{1}, U32{0}, F32{1}, F32{-2}, F32{3.5F}),
                      SmpteTimecode(), TwoSkeletons()));
  EXPECT_EQ(EncodeFrame(*frame, std::span(out).first(out.size() - 1)), 0U);
}

}  // namespace
}  // namespace styled::qtm
