#include "proto/rigs/natnet/model.h"

#include <gtest/gtest.h>

#include "tests/unit/natnet/decode_cases.h"

namespace styled::natnet {
namespace {

using namespace testing;

TEST(Model, CutShortAnywhereIsRefused) {
  static Model model;
  for (const Version v : {k27, k30, k40, k41, k42, k50}) {
    const Bytes whole = FullModel(v);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto cut = std::span(whole).first(size);
      EXPECT_NE(DecodeModel(cut, v, model), DecodeResult::kOk) << ToString(v) << " at " << size;
    }
  }
}

TEST(Model, GivesItsSkeletonsWhateverStandsBetweenThem) {
  static Model model;
  for (const Version v : {k27, k29, k30, k31, k40, k41, k42}) {
    SCOPED_TRACE(ToString(v));
    const Bytes payload = FullModel(v);
    ASSERT_EQ(DecodeModel(payload, v, model), DecodeResult::kOk);
    EXPECT_TRUE(model.complete);
    EXPECT_EQ(model.rigid_body_count, 1U);
    ASSERT_EQ(model.rigid_bodies_read, 1U);
    EXPECT_EQ(model.rigid_bodies[0].name, "Prop");
    EXPECT_EQ(model.rigid_bodies[0].id, 1);
    EXPECT_EQ(model.rigid_bodies[0].parent, -1);
    ASSERT_EQ(model.skeleton_count, 2U);
    EXPECT_EQ(model.skeletons[0].name, "Anna");
    EXPECT_EQ(model.skeletons[0].id, 7);
    EXPECT_EQ(model.skeletons[1].name, "Bert");
    EXPECT_EQ(model.skeletons[1].id, 8);
    for (std::size_t s = 0; s < 2; ++s) {
      ASSERT_EQ(model.skeletons[s].bone_count, 2U);
      const BoneDescription &hip = model.skeletons[s].bones[0], &ab = model.skeletons[s].bones[1];
      EXPECT_EQ(hip.name, "Hip");
      EXPECT_EQ(hip.id, 1);
      EXPECT_EQ(hip.parent, 0);
      EXPECT_EQ(hip.offset_m, (std::array<float, 3>{0.5F, 1, -0.5F}));
      EXPECT_EQ(ab.name, "Ab");
      EXPECT_EQ(ab.id, 2);
      EXPECT_EQ(ab.parent, 1);
      EXPECT_EQ(ab.offset_m, (std::array<float, 3>{0.5F, 0.125F, -0.5F}));
    }
  }
}

// A whole 3.0 definition byte by byte: one skeleton, of two bones.
TEST(Model, Of30IsReadFromBytesWrittenByHand) {
  constexpr unsigned char kBytes[] = {
      0x01, 0x00, 0x00, 0x00,                          // 1 data set
      0x02, 0x00, 0x00, 0x00,                          // a skeleton
      'A',  'n',  'n',  'a',  0x00,                    //   "Anna"
      0x03, 0x00, 0x00, 0x00,                          //   id 3
      0x02, 0x00, 0x00, 0x00,                          //   2 bones
      'H',  'i',  'p',  0x00,                          //   "Hip"
      0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,  //     id 1, no parent
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x80, 0x3F,  //     x 0, y 1
      0x00, 0x00, 0x00, 0x00,                          //     z 0
      0x00, 0x00, 0x00, 0x00,                          //     no markers
      'A',  'b',  0x00,                                //   "Ab"
      0x02, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00,  //     id 2, parent 1
      0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x3E,  //     x 0, y 0.125
      0x00, 0x00, 0x80, 0xBE,                          //     z -0.25
      0x00, 0x00, 0x00, 0x00                           //     no markers
  };
  static Model model;
  ASSERT_EQ(DecodeModel(std::as_bytes(std::span(kBytes)), k30, model), DecodeResult::kOk);
  ASSERT_EQ(model.skeleton_count, 1U);
  EXPECT_EQ(model.skeletons[0].name, "Anna");
  EXPECT_EQ(model.skeletons[0].id, 3);
  ASSERT_EQ(model.skeletons[0].bone_count, 2U);
  EXPECT_EQ(model.skeletons[0].bones[1].name, "Ab");
  EXPECT_EQ(model.skeletons[0].bones[1].parent, 1);
  EXPECT_EQ(model.skeletons[0].bones[1].offset_m, (std::array<float, 3>{0, 0.125F, -0.25F}));
  Bytes again(1000);
  again.resize(EncodeModel(model, k30, again));
  const auto bytes = std::as_bytes(std::span(kBytes));
  EXPECT_TRUE(std::ranges::equal(std::span(again).subspan(kHeaderSize), bytes));
}

TEST(Model, SkipsWhatItDoesNotKnowWhereSizesAreGiven) {
  static Model model;
  for (const Version v : {k41, k42, k50}) {
    const Bytes payload = Join(I32{3}, I32{6}, I32{33}, Any{33}, I32{77}, I32{0}, I32{2},
                               Sized(v, SkeletonSet(v, "Anna", 7)), Any{9});
    ASSERT_EQ(DecodeModel(payload, v, model), DecodeResult::kOk);
    EXPECT_TRUE(model.complete);
    EXPECT_EQ(model.skeleton_count, 1U);
  }
}

TEST(Model, StopsAtWhatItDoesNotKnowWhereNoSizesAreGivenAndSaysSo) {
  static Model model;
  const Bytes payload = Join(I32{3}, I32{2}, Part{SkeletonSet(k30, "Anna", 7)}, I32{77}, Any{33});
  ASSERT_EQ(DecodeModel(payload, k30, model), DecodeResult::kOk);
  EXPECT_FALSE(model.complete);
  ASSERT_EQ(model.skeleton_count, 1U);
  EXPECT_EQ(model.skeletons[0].name, "Anna");
  ASSERT_EQ(DecodeModel(Join(I32{1}, I32{3}, Any{33}), k29, model), DecodeResult::kOk);
  EXPECT_FALSE(model.complete);
}

TEST(Model, LeavesOutSkeletonsThatItHasNoRoomFor) {
  static Model model;
  for (const Version v : {k27, k30, k41, k42}) {
    Bytes sets = Join(I32{18});
    for (int s = 0; s < 18; ++s) {
      const int bones = s == 3 ? 65 : 1;
      Bytes set = Join(Text{"A"}, I32{s}, I32{bones});
      for (int b = 0; b < bones; ++b) Description(v, "Hip", b + 1, b, 1).AppendTo(set);
      Part{Join(I32{2}, Sized(v, set))}.AppendTo(sets);
    }
    ASSERT_EQ(DecodeModel(sets, v, model), DecodeResult::kOk) << ToString(v);
    EXPECT_EQ(model.skeleton_count, kMaxSkeletons);
    EXPECT_EQ(model.skeletons_left_out, 2U);
    EXPECT_EQ(model.skeletons[3].id, 4);
    EXPECT_EQ(model.skeletons[15].id, 16);
  }
}

TEST(Model, AModelIsDecodedUnchangedAndRefusedWhereItDoesNotFit) {
  static Model sent, received;
  for (const Version v : {k27, k30, k40, k41, k42, k50}) {
    const Bytes payload = FullModel(v);
    ASSERT_EQ(DecodeModel(payload, v, sent), DecodeResult::kOk);
    Bytes packet(kMaxPacketSize);
    packet.resize(EncodeModel(sent, v, packet));
    Packet split;
    ASSERT_EQ(DecodePacket(packet, split), DecodeResult::kOk);
    EXPECT_EQ(split.id, MessageId::kModelDef);
    ASSERT_EQ(DecodeModel(split.payload, v, received), DecodeResult::kOk);
    ASSERT_EQ(received.skeleton_count, 2U);
    for (std::size_t s = 0; s < 2; ++s) {
      EXPECT_EQ(received.skeletons[s].name, sent.skeletons[s].name);
      for (std::size_t b = 0; b < 2; ++b) {
        const BoneDescription &a = sent.skeletons[s].bones[b], &c = received.skeletons[s].bones[b];
        EXPECT_TRUE(a.name == c.name && a.id == c.id && a.parent == c.parent &&
                    a.offset_m == c.offset_m);
      }
    }
    Bytes small(packet.size() - 1);
    EXPECT_EQ(EncodeModel(sent, v, small), 0U);
  }
}

}  // namespace
}  // namespace styled::natnet
