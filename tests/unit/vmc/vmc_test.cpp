#include "proto/rigs/vmc/vmc.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/vmc/message_cases.h"

namespace styled::vmc {
namespace {

using testing::Bytes;
using testing::F;
using testing::Floats;
using testing::I;
using testing::S;

DecodeResult DecodeOne(const Bytes& bytes, Message& message) {
  osc::Reader reader(bytes);
  osc::Message raw;
  EXPECT_EQ(reader.Next(raw), osc::Reader::Step::kMessage);
  return Decode(raw, message);
}

template <typename T>
Bytes Encoded(const T& message) {
  Bytes out(512);
  osc::Writer writer(out);
  Put(message, writer);
  EXPECT_TRUE(writer.ok());
  out.resize(writer.size());
  return out;
}

TEST(VmcMessage, EveryCaseOfTheTableGivesItsReason) {
  for (const auto& c : testing::MessageCases()) {
    Message message;
    EXPECT_EQ(Name(DecodeOne(c.bytes, message)), Name(c.expected)) << c.name;
  }
}

TEST(VmcMessage, IsLeftAloneByARefusedOne) {
  for (const auto& c : testing::MessageCases()) {
    if (c.expected == DecodeResult::kOk) continue;
    Message message = Time{42};
    EXPECT_NE(DecodeOne(c.bytes, message), DecodeResult::kOk);
    ASSERT_TRUE(std::holds_alternative<Time>(message)) << c.name;
    EXPECT_EQ(std::get<Time>(message).seconds, 42) << c.name;
  }
}

// As the table of the specification counts its arguments, byte for byte.
TEST(VmcMessage, BoneIsReadAsItIsWrittenDown) {
  const Bytes bytes = testing::ToBytes({"/VMC/Ext/Bone/Pos\0\0\0"
                                        ",sfffffff\0\0\0"
                                        "LeftUpperLeg\0\0\0\0",
                                        48}) +
                      I(0x3DB851EC) + I(0xBF800000) + I(0) +  // 0.09, -1, 0
                      I(0x3F000000) + I(0xBF000000) + I(0x3F000000) + I(0x3F000000);
  EXPECT_EQ(bytes.size(), 76U);
  Message message;
  ASSERT_EQ(DecodeOne(bytes, message), DecodeResult::kOk);
  const auto& bone = std::get<Bone>(message);
  EXPECT_EQ(bone.name, "LeftUpperLeg");
  EXPECT_EQ(bone.transform, (Transform{{0.09F, -1, 0}, {0.5F, -0.5F, 0.5F, 0.5F}}));
  EXPECT_EQ(Encoded(bone), bytes);
}

TEST(VmcMessage, RootIsReadWithScaleAndOffsetOfMixedReality) {
  const Bytes bytes = S("/VMC/Ext/Root/Pos") + S(",sfffffffffffff") + S("root") +
                      Floats({1, 2, 3, 0, 1, 0, 0, 9, 9, 9, 8, 8, 8});
  Message message;
  ASSERT_EQ(DecodeOne(bytes, message), DecodeResult::kOk);
  EXPECT_EQ(std::get<Root>(message).transform, (Transform{{1, 2, 3}, {0, 1, 0, 0}}));
}

// VMCLiveLink takes no root of any other length.
TEST(VmcMessage, RootIsWrittenWithEightArguments) {
  EXPECT_EQ(Encoded(Root{{{1, 2, 3}, {0, 1, 0, 0}}}),
            S("/VMC/Ext/Root/Pos") + S(",sfffffff") + S("root") + Floats({1, 2, 3, 0, 1, 0, 0}));
}

TEST(VmcMessage, OkOfEveryVersionIsRead) {
  const auto read = [](const Bytes& bytes) {
    Message message;
    EXPECT_EQ(DecodeOne(bytes, message), DecodeResult::kOk);
    return std::get<Available>(message);
  };
  const Available oldest = read(S("/VMC/Ext/OK") + S(",i") + I(0));
  EXPECT_EQ(oldest.loaded, 0);
  EXPECT_EQ(oldest.calibration_state, 3);
  EXPECT_EQ(oldest.tracking, 1);
  const Available v25 = read(S("/VMC/Ext/OK") + S(",iii") + I(1) + I(2) + I(1));
  EXPECT_EQ(v25.loaded, 1);
  EXPECT_EQ(v25.calibration_state, 2);
  EXPECT_EQ(v25.calibration_mode, 1);
  EXPECT_EQ(v25.tracking, 1);
  const Available v27 = read(S("/VMC/Ext/OK") + S(",iiii") + I(1) + I(3) + I(0) + I(0));
  EXPECT_EQ(v27.tracking, 0);
  EXPECT_EQ(Encoded(v27), S("/VMC/Ext/OK") + S(",iiii") + I(1) + I(3) + I(0) + I(0));
}

TEST(VmcMessage, ExpressionsAreReadAndWritten) {
  Message message;
  const Bytes bytes = testing::BlendMessage("mouthSmileLeft", 0.25F);
  ASSERT_EQ(DecodeOne(bytes, message), DecodeResult::kOk);
  EXPECT_EQ(std::get<Blend>(message).name, "mouthSmileLeft");
  EXPECT_EQ(std::get<Blend>(message).value, 0.25F);
  EXPECT_EQ(Encoded(std::get<Blend>(message)), bytes);
  EXPECT_EQ(Encoded(BlendApply()), testing::ApplyMessage());
  EXPECT_EQ(Encoded(Time{12.5F}), testing::TimeMessage(12.5F));
}

TEST(VmcMessage, ThruIsPassedOnByteForByte) {
  for (const Bytes& bytes : {S("/VMC/Thru/app/word") + S(",s") + S("hello"),
                             S("/VMC/Thru/app/number") + S(",sf") + S("x") + F(-1),
                             S("/VMC/Thru/app/count") + S(",si") + S("x") + I(3)}) {
    Message message;
    ASSERT_EQ(DecodeOne(bytes, message), DecodeResult::kOk);
    EXPECT_EQ(Encoded(std::get<Thru>(message)), bytes);
  }
}

}  // namespace
}  // namespace styled::vmc
