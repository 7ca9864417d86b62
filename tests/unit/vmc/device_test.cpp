#include "proto/rigs/vmc/device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/vmc/bytes.h"
#include "tests/unit/vmc/witness.h"

namespace styled::vmc {
namespace {

using testing::Bytes;
using testing::Floats;
using testing::S;

// By hand, after the protocol's document.
Bytes Written(const std::string& address) {
  return S(address) + S(",sfffffff") + S("LHR-1") + Floats({1, 2, 3, 0.5F, -0.5F, 0.5F, -0.5F});
}

DecodeResult Read(const Bytes& bytes, Device& device) {
  osc::Reader reader(bytes);
  osc::Message message;
  EXPECT_EQ(reader.Next(message), osc::Reader::Step::kMessage);
  return Decode(message, device);
}

TEST(Device, IsReadAndWrittenAsTheDocumentHasIt) {
  const std::pair<const char*, Device::Kind> rows[] = {
      {"/VMC/Ext/Hmd/Pos", Device::Kind::kHmd},
      {"/VMC/Ext/Con/Pos", Device::Kind::kController},
      {"/VMC/Ext/Tra/Pos", Device::Kind::kTracker}};
  for (const auto& [address, kind] : rows) {
    const Bytes bytes = Written(address);
    Device device;
    ASSERT_EQ(Read(bytes, device), DecodeResult::kOk) << address;
    EXPECT_EQ(device.kind, kind);
    EXPECT_EQ(device.serial, "LHR-1");
    EXPECT_EQ(device.transform, (Transform{{1, 2, 3}, {0.5F, -0.5F, 0.5F, -0.5F}}));
    Bytes again(bytes.size());
    osc::Writer writer(again);
    Put(device, writer);
    EXPECT_TRUE(writer.ok());
    EXPECT_EQ(again, bytes);
    EXPECT_EQ(testing::ReadLiblo(again).messages, testing::ReadOurs(bytes).messages);
    EXPECT_EQ(testing::ReadOscpack(again).messages, testing::ReadOurs(bytes).messages);
  }
}

TEST(Device, IsNotAButtonNorARawPose) {
  Device device;
  EXPECT_EQ(Read(Written("/VMC/Ext/Tra/Pos/Local"), device), DecodeResult::kUnknownAddress);
  EXPECT_EQ(Read(Written("/VMC/Ext/Hmd"), device), DecodeResult::kUnknownAddress);
  EXPECT_EQ(Read(Written("/VMC/Ext/Bone/Pos"), device), DecodeResult::kUnknownAddress);
  const Bytes button = S("/VMC/Ext/Con") + S(",isiiifff") + testing::I(1) + S("Trigger") +
                       testing::I(1) + testing::I(1) + testing::I(0) + Floats({0, 0, 0});
  EXPECT_EQ(Read(button, device), DecodeResult::kUnknownAddress);
}

TEST(Device, NeedsAllItsArguments) {
  Device device;
  device.serial = "untouched";
  EXPECT_EQ(Read(S("/VMC/Ext/Tra/Pos") + S(",sff") + S("a") + Floats({1, 2}), device),
            DecodeResult::kTooFewArguments);
  EXPECT_EQ(Read(S("/VMC/Ext/Tra/Pos") + S(",fffffff") + Floats({1, 2, 3, 4, 5, 6, 7}), device),
            DecodeResult::kWrongType);
  EXPECT_EQ(device.serial, "untouched");
}

}  // namespace
}  // namespace styled::vmc
