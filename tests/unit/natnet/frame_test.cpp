#include "proto/rigs/natnet/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/natnet/decode_cases.h"

namespace styled::natnet {
namespace {

using namespace testing;

void ExpectEveryReason(const std::vector<DecodeCase>& cases) {
  static Frame frame;
  static Model model;
  for (const DecodeCase& c : cases) {
    const auto result = c.id == MessageId::kModelDef ? DecodeModel(c.payload, c.version, model)
                                                     : DecodeFrame(c.payload, c.version, frame);
    EXPECT_EQ(Name(result), Name(c.expected)) << c.name;
  }
}

TEST(Frame, IsRefusedWithItsReasonInEveryCaseOfTheTable) { ExpectEveryReason(WrongFrames()); }

TEST(Frame, IsReadInEveryRightCaseOfTheTable) { ExpectEveryReason(RightCases()); }

TEST(Model, IsRefusedWithItsReasonInEveryCaseOfTheTable) { ExpectEveryReason(WrongModels()); }

TEST(Frame, CutShortAnywhereIsRefused) {
  static Frame frame;
  for (const Version v : {k27, k29, k30, k31, k40, k41, k42, k50}) {
    const Bytes whole = FullFrame(v);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto cut = std::span(whole).first(size);
      EXPECT_NE(DecodeFrame(cut, v, frame), DecodeResult::kOk) << ToString(v) << " at " << size;
    }
  }
}

void ExpectBone(const Bone& bone, int id, float x, float qw, bool tracked) {
  EXPECT_EQ(bone.id, id);
  EXPECT_EQ(bone.description_id(), id & 0xFFFF);
  EXPECT_EQ(bone.position_m, (std::array<float, 3>{x, x + 1, x + 2}));
  EXPECT_EQ(bone.rotation, (std::array<float, 4>{0.5F, -0.5F, 0.25F, qw}));
  EXPECT_EQ(bone.tracked, tracked);
}

TEST(Frame, GivesItsSkeletonsAndTimesWhateverStandsAroundThem) {
  static Frame frame;
  for (const Version v : {k27, k29, k30, k31, k40, k41, k42}) {
    SCOPED_TRACE(ToString(v));
    ASSERT_EQ(DecodeFrame(FullFrame(v), v, frame), DecodeResult::kOk);
    EXPECT_EQ(frame.number, 162734);
    EXPECT_EQ(frame.rigid_body_count, 3U);
    ASSERT_EQ(frame.rigid_bodies_read, 3U);
    ExpectBone(frame.rigid_bodies[0], 1, 1, 1, true);
    ExpectBone(frame.rigid_bodies[1], 2, 2, 1, false);
    ExpectBone(frame.rigid_bodies[2], 3, 3, 1, true);
    ASSERT_EQ(frame.skeleton_count, 2U);
    EXPECT_EQ(frame.skeletons_left_out, 0U);
    EXPECT_EQ(frame.skeletons[0].id, 7);
    ASSERT_EQ(frame.skeletons[0].bone_count, 2U);
    ExpectBone(frame.skeletons[0].bones[0], (7 << 16) | 1, 10, 0.75F, true);
    ExpectBone(frame.skeletons[0].bones[1], (7 << 16) | 2, 20, 1, false);
    EXPECT_EQ(frame.skeletons[1].id, 8);
    ASSERT_EQ(frame.skeletons[1].bone_count, 1U);
    ExpectBone(frame.skeletons[1].bones[0], (8 << 16) | 1, 30, -1, true);
    EXPECT_EQ(frame.timecode, 0x0A0B0C0DU);
    EXPECT_EQ(frame.timecode_subframe, 2U);
    EXPECT_EQ(frame.timestamp_s, 1356.125);
    EXPECT_EQ(frame.exposure_ticks, v < k30 ? 0U : 0x0123456789ABCDEFU);
    EXPECT_EQ(frame.received_ticks, v < k30 ? 0U : 2U);
    EXPECT_EQ(frame.transmit_ticks, v < k30 ? 0U : 3U);
    EXPECT_EQ(frame.params, kModelsChanged | kEditing);
  }
}

// A whole 4.1 frame, byte by byte, as protocols of the format describe it: one skeleton (id 2) of
// two bones, the second not tracked; no other section is used.
TEST(Frame, Of41IsReadFromBytesWrittenByHand) {
  constexpr unsigned char kBytes[] = {
      0x2A, 0x00, 0x00, 0x00,                          // frame 42
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // marker sets: 0 in 0 bytes
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // unlabelled markers
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // rigid bodies
      0x01, 0x00, 0x00, 0x00, 0x54, 0x00, 0x00, 0x00,  // skeletons: 1 in 84 = 8 + 2 * 38 bytes
      0x02, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00,  //   id 2, 2 bones
      0x01, 0x00, 0x02, 0x00,                          //     bone 1 of skeleton 2
      0x00, 0x00, 0x80, 0x3F,                          //     x 1
      0x00, 0x00, 0x00, 0x40,                          //     y 2
      0x00, 0x00, 0x40, 0xC0,                          //     z -3
      0x00, 0x00, 0x00, 0x00,                          //     qx 0
      0xF3, 0x04, 0x35, 0x3F,                          //     qy 0.70710677
      0x00, 0x00, 0x00, 0x00,                          //     qz 0
      0xF3, 0x04, 0x35, 0x3F,                          //     qw 0.70710677
      0x00, 0x00, 0x00, 0x00,                          //     mean error 0
      0x01, 0x00,                                      //     params: tracked
      0x02, 0x00, 0x02, 0x00,                          //     bone 2
      0x00, 0x00, 0x00, 0x3F,                          //     x 0.5
      0x00, 0x00, 0x00, 0x3E,                          //     y 0.125
      0x00, 0x00, 0x00, 0x00,                          //     z 0
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  //     qx, qy 0
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3F,  //     qz 0, qw 1
      0x0A, 0xD7, 0x23, 0x3C, 0x00, 0x00,              //     mean error 0.01; not tracked
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // assets
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // labelled markers
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // force plates
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // devices
      0x11, 0x3B, 0x17, 0x0A, 0x00, 0x00, 0x00, 0x00,  // timecode 10:23:59:17, subframe 0
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xF8, 0x3F,  // 1.5 s
      0x10, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // exposed at tick 16
      0x20, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // received
      0x30, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // sent
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  // PTP
      0x01, 0x00,                                      // recording
      0x00, 0x00, 0x00, 0x00                           // end
  };
  static Frame frame;
  ASSERT_EQ(DecodeFrame(std::as_bytes(std::span(kBytes)), k41, frame), DecodeResult::kOk);
  EXPECT_EQ(frame.number, 42);
  ASSERT_EQ(frame.skeleton_count, 1U);
  ASSERT_EQ(frame.skeletons[0].bone_count, 2U);
  const Bone& hip = frame.skeletons[0].bones[0];
  EXPECT_EQ(hip.description_id(), 1);
  EXPECT_EQ(hip.position_m, (std::array<float, 3>{1, 2, -3}));
  EXPECT_EQ(hip.rotation, (std::array<float, 4>{0, 0.70710677F, 0, 0.70710677F}));
  EXPECT_TRUE(hip.tracked);
  const Bone& ab = frame.skeletons[0].bones[1];
  EXPECT_EQ(ab.description_id(), 2);
  EXPECT_EQ(ab.position_m, (std::array<float, 3>{0.5F, 0.125F, 0}));
  EXPECT_EQ(ab.rotation, (std::array<float, 4>{0, 0, 0, 1}));
  EXPECT_FALSE(ab.tracked);
  EXPECT_EQ(frame.timecode, 0x0A173B11U);
  EXPECT_EQ(frame.timestamp_s, 1.5);
  EXPECT_EQ(frame.exposure_ticks, 16U);
  EXPECT_EQ(frame.received_ticks, 32U);
  EXPECT_EQ(frame.transmit_ticks, 48U);
  EXPECT_EQ(frame.params, kRecording);
  // Our encoder writes the same, except for the mean error, which it does not have.
  Bytes again(2000);
  again.resize(EncodeFrame(frame, k41, again));
  ASSERT_EQ(again.size(), kHeaderSize + sizeof kBytes);
  EXPECT_EQ(again[0], std::byte{7});
  EXPECT_EQ(again[2], std::byte{sizeof kBytes & 0xFF});
  std::size_t differing = 0;
  for (std::size_t i = 0; i < sizeof kBytes; ++i) {
    differing += again[kHeaderSize + i] == std::byte{kBytes[i]} ? 0 : 1;
  }
  EXPECT_EQ(differing, 4U);
}

TEST(Frame, OfALaterBitstreamGivesItsSkeletonsThoughOtherSectionsGrew) {
  static Frame frame;
  const Bytes body = Join(Body(k41, (7 << 16) | 1, 10, 0.75F, 1));
  Bytes payload = Join(I32{3}, I32{1}, I32{3}, Any{3}, I32{0}, I32{0}, I32{1}, I32{99}, Any{99},
                       I32{1}, I32{static_cast<int>(body.size()) + 8 + 5}, I32{7}, I32{1},
                       Part{body}, Any{5}, Part{Tail(k41, false)}, Any{12});
  ASSERT_EQ(DecodeFrame(payload, k50, frame), DecodeResult::kOk);
  ASSERT_EQ(frame.skeleton_count, 1U);
  ExpectBone(frame.skeletons[0].bones[0], (7 << 16) | 1, 10, 0.75F, true);
  EXPECT_EQ(frame.timestamp_s, 1356.125);
  EXPECT_EQ(DecodeFrame(payload, k41, frame), DecodeResult::kBadCount);
}

TEST(Frame, Of41MayHaveALongerEnd) {
  static Frame frame;
  const Bytes payload =
      Join(Part{Head(k41, true)}, I32{0}, Sized(k41, {}), Part{Tail(k41, true, 20)});
  EXPECT_EQ(DecodeFrame(payload, k41, frame), DecodeResult::kOk);
  EXPECT_EQ(frame.params, kModelsChanged | kEditing);
}

TEST(Frame, LeavesOutSkeletonsThatItHasNoRoomFor) {
  static Frame frame;
  for (const Version v : {k27, k30, k41}) {
    Bytes skeletons;
    for (int s = 0; s < 18; ++s) {
      const int bones = s == 3 ? 65 : 1;
      Part{Join(I32{s}, I32{bones})}.AppendTo(skeletons);
      for (int b = 0; b < bones; ++b) Body(v, b, 1, 1, 1).AppendTo(skeletons);
    }
    const Bytes payload =
        Join(Part{Head(v, false)}, I32{18}, Sized(v, skeletons), Part{Tail(v, false)});
    ASSERT_EQ(DecodeFrame(payload, v, frame), DecodeResult::kOk) << ToString(v);
    EXPECT_EQ(frame.skeleton_count, kMaxSkeletons);
    EXPECT_EQ(frame.skeletons_left_out, 2U);
    EXPECT_EQ(frame.skeletons[2].id, 2);
    EXPECT_EQ(frame.skeletons[3].id, 4);
    EXPECT_EQ(frame.skeletons[15].id, 16);
    EXPECT_EQ(frame.timestamp_s, 1356.125);
  }
}

TEST(Frame, ComesBackAsItWasSentWithSixteenSkeletonsOf64Bones) {
  static Frame sent, received;
  sent.number = 99;
  sent.skeleton_count = kMaxSkeletons;
  for (std::size_t s = 0; s < kMaxSkeletons; ++s) {
    sent.skeletons[s].id = static_cast<std::int32_t>(s + 1);
    sent.skeletons[s].bone_count = kMaxBones - s;
    for (std::size_t b = 0; b < kMaxBones - s; ++b) {
      const auto f = static_cast<float>(s * 100 + b);
      sent.skeletons[s].bones[b] = {static_cast<std::int32_t>((s + 1) << 16 | (b + 1)),
                                    {f, -f, f / 2},
                                    {f / 3, 0, 1, -f},
                                    b % 3 != 0};
    }
  }
  for (const Version v : {k27, k29, k30, k31, k40, k41, k42}) {
    Bytes packet(kMaxPacketSize);
    packet.resize(EncodeFrame(sent, v, packet));
    Packet split;
    ASSERT_EQ(DecodePacket(packet, split), DecodeResult::kOk);
    EXPECT_EQ(split.id, MessageId::kFrameOfData);
    ASSERT_EQ(DecodeFrame(split.payload, v, received), DecodeResult::kOk);
    ASSERT_EQ(received.skeleton_count, kMaxSkeletons);
    for (std::size_t s = 0; s < kMaxSkeletons; ++s) {
      ASSERT_EQ(received.skeletons[s].bone_count, kMaxBones - s);
      for (std::size_t b = 0; b < kMaxBones - s; ++b) {
        const Bone &a = sent.skeletons[s].bones[b], &c = received.skeletons[s].bones[b];
        EXPECT_TRUE(a.id == c.id && a.position_m == c.position_m && a.rotation == c.rotation &&
                    a.tracked == c.tracked);
      }
    }
  }
}

TEST(Frame, IsNotWrittenWhereItDoesNotFit) {
  static Frame frame;
  ASSERT_EQ(DecodeFrame(FullFrame(k30), k30, frame), DecodeResult::kOk);
  Bytes out(kMaxPacketSize);
  const std::size_t size = EncodeFrame(frame, k30, out);
  ASSERT_GT(size, 0U);
  for (std::size_t room = 0; room < size; ++room) {
    EXPECT_EQ(EncodeFrame(frame, k30, std::span(out).first(room)), 0U);
  }
  EXPECT_EQ(EncodeFrame(frame, k30, std::span(out).first(size)), size);
}

TEST(DecodeResult, IsReachedByTheTables) {
  const auto cases = DecodeCases();
  for (auto reason = static_cast<int>(DecodeResult::kOldVersion);
       reason < static_cast<int>(DecodeResult::kCount); ++reason) {
    EXPECT_TRUE(std::ranges::any_of(cases, [reason](const auto& c) {
      return static_cast<int>(c.expected) == reason;
    })) << Name(DecodeResult(reason));
  }
}

}  // namespace
}  // namespace styled::natnet
