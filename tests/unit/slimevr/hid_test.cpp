#include "proto/rigs/slimevr/hid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/unit/slimevr/decode_cases.h"

namespace styled::slimevr {
namespace {

using testing::Bytes;
using ::testing::ElementsAre;
using ::testing::FloatNear;

constexpr float kSqrtHalf = 0.70710678F;

Record DecodeOne(const Bytes& bytes) {
  Report report;
  EXPECT_EQ(DecodeReport(bytes, report), ReportResult::kOk);
  EXPECT_EQ(report.count, 1U);
  return report.records[0];
}

template <typename T>
T RecordAs(const Bytes& bytes) {
  const Record record = DecodeOne(bytes);
  EXPECT_EQ(record.tracker, 3);
  const T* body = std::get_if<T>(&record.body);
  if (body == nullptr) {
    ADD_FAILURE() << "another type";
    return {};
  }
  return *body;
}

Bytes Encode(const Record& record) {
  Bytes bytes(kRecordSize, std::byte{0xAA});
  EncodeRecord(record, std::span<std::byte, kRecordSize>(bytes));
  return bytes;
}

float Degrees(const std::array<float, 4>& a, const std::array<float, 4>& b) {
  float dot = 0;
  for (std::size_t i = 0; i < 4; ++i) dot += a[i] * b[i];
  const float chord = std::sqrt(std::max(0.0F, 2 - 2 * std::abs(dot)));
  return 4 * std::asin(std::min(1.0F, chord / 2)) * 180 / std::numbers::pi_v<float>;
}

TEST(Report, EveryCaseOfTheTableGivesItsReason) {
  for (const auto& c : testing::ReportCases()) {
    Report report;
    EXPECT_EQ(Name(DecodeReport(c.bytes, report)), Name(c.expected)) << c.name;
  }
}

TEST(Report, EveryReasonIsReachedByTheTable) {
  for (int reason = 0; reason < static_cast<int>(ReportResult::kCount); ++reason) {
    const auto cases = testing::ReportCases();
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [reason](const auto& c) {
      return static_cast<int>(c.expected) == reason;
    })) << Name(ReportResult(reason));
  }
}

TEST(Report, IsLeftAloneByARefusedOne) {
  Report report;
  report.count = 2;
  report.unknown = 7;
  EXPECT_NE(DecodeReport(Bytes(65), report), ReportResult::kOk);
  EXPECT_NE(DecodeReport(Bytes(80), report), ReportResult::kOk);
  EXPECT_NE(DecodeReport({}, report), ReportResult::kOk);
  EXPECT_EQ(report.count, 2U);
  EXPECT_EQ(report.unknown, 7U);
}

TEST(Report, PassesOverTypesToComeAndCountsThem) {
  const Bytes unknown = testing::Hex("FD 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
  Report report;
  ASSERT_EQ(DecodeReport(testing::Join({unknown, testing::kMotionRecord, unknown,
                                        testing::kRegistrationRecord}),
                         report),
            ReportResult::kOk);
  ASSERT_EQ(report.count, 2U);
  EXPECT_EQ(report.unknown, 2U);
  EXPECT_TRUE(std::holds_alternative<Motion>(report.records[0].body));
  EXPECT_TRUE(std::holds_alternative<Registration>(report.records[1].body));
}

TEST(Record, InfoIsReadAsTheFirmwareWritesIt) {
  const auto info = RecordAs<Info>(testing::kInfoRecord);
  EXPECT_EQ(info.battery.percent, 87);
  EXPECT_NEAR(info.battery.volts, 3.95F, 1e-5F);
  EXPECT_FLOAT_EQ(info.battery.temperature_c, 31);
  EXPECT_EQ(info.board, 9);
  EXPECT_EQ(info.mcu, 10);
  EXPECT_EQ(info.imu, 13);
  EXPECT_EQ(info.magnetometer, 2);
  EXPECT_EQ(info.firmware_year, 2026);
  EXPECT_EQ(info.firmware_month, 4);
  EXPECT_EQ(info.firmware_day, 12);
  EXPECT_THAT(info.firmware_version, ElementsAre(1, 2, 3));
  EXPECT_EQ(info.signal, 60);
}

// HIDCommon.kt: 128 is shown as 0 %, 0 hides the battery, temperature 0 is none.
TEST(Record, AnEmptyBatteryDiffersFromNone) {
  Bytes bytes = testing::kInfoRecord;
  bytes[2] = std::byte{128};
  EXPECT_EQ(RecordAs<Info>(bytes).battery.percent, 0);
  bytes[2] = std::byte{0};
  bytes[4] = std::byte{0};
  EXPECT_EQ(RecordAs<Info>(bytes).battery.percent, -1);
  EXPECT_TRUE(std::isnan(RecordAs<Info>(bytes).battery.temperature_c));
}

TEST(Record, MotionIsReadAsTheFirmwareWritesIt) {
  const auto motion = RecordAs<Motion>(testing::kMotionRecord);
  EXPECT_TRUE(motion.orientation.usable);
  EXPECT_THAT(motion.orientation.rotation,
              ElementsAre(0, 0, FloatNear(kSqrtHalf, 1e-6F), FloatNear(kSqrtHalf, 1e-6F)));
  EXPECT_THAT(motion.acceleration_mps2, ElementsAre(0, 0, FloatNear(9.80665F, 1.0F / 128)));
}

TEST(Record, MotionAndBatteryAreReadAsTheFirmwareWritesThem) {
  const auto record = RecordAs<MotionAndBattery>(testing::kMotionAndBatteryRecord);
  EXPECT_EQ(record.battery.percent, 87);
  EXPECT_NEAR(record.battery.volts, 3.95F, 1e-5F);
  EXPECT_LT(Degrees(record.motion.orientation.rotation, {0, 0, kSqrtHalf, kSqrtHalf}), 0.01F);
  EXPECT_THAT(record.motion.acceleration_mps2, ElementsAre(-1, 0.5F, FloatNear(9.8F, 0.01F)));
  EXPECT_EQ(record.signal, 60);
}

TEST(Record, StatusRuntimeAndButtonAreReadAsTheFirmwareWritesThem) {
  const auto status = RecordAs<Status>(testing::kStatusRecord);
  EXPECT_EQ(status.server_status, 1);
  EXPECT_EQ(status.raw_status, 7);
  EXPECT_EQ(status.received, 100);
  EXPECT_EQ(status.lost, 2);
  EXPECT_EQ(status.windows_hit, 99);
  EXPECT_EQ(status.windows_missed, 1);
  EXPECT_EQ(status.signal, 60);
  EXPECT_EQ(RecordAs<Runtime>(testing::kRuntimeRecord).remaining_us, 3'600'000'000);
  const auto button = RecordAs<Button>(testing::kButtonRecord);
  EXPECT_EQ(button.button, 1);
  EXPECT_EQ(button.sleep_ms, 10'000);
  const auto both = RecordAs<MotionAndButton>(testing::kMotionAndButtonRecord);
  EXPECT_EQ(both.button.button, 2);
  EXPECT_EQ(both.button.sleep_ms, 65'535);
  EXPECT_EQ(both.button.signal, 60);
  EXPECT_LT(Degrees(both.motion.orientation.rotation, {0, 0, 0, 1}), 0.01F);
}

TEST(Record, AnUnknownRuntimeIsMinusOne) {
  const Bytes bytes = testing::Hex("05 03 FF FF FF FF FF FF FF FF 00 00 00 00 00 00");
  EXPECT_EQ(RecordAs<Runtime>(bytes).remaining_us, -1);
}

TEST(Record, TheMagnetometerIsReadAsTheFirmwareWritesIt) {
  const auto record = RecordAs<MotionAndMagnetometer>(testing::kMagnetometerRecord);
  EXPECT_THAT(record.orientation.rotation, ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(record.magnetometer_gauss, ElementsAre(0.5F, 0, -0.5F));
}

TEST(Record, ARegistrationHasTheAddressOfTheServersOwnTest) {
  const Record record = DecodeOne(testing::kRegistrationRecord);
  EXPECT_EQ(record.tracker, 2);
  const auto* body = std::get_if<Registration>(&record.body);
  ASSERT_NE(body, nullptr);
  EXPECT_EQ(body->address, 0x000102030405U);
}

TEST(Record, ARotationOfZerosIsIdentityAndNotUsable) {
  const auto motion = RecordAs<Motion>(testing::Join({testing::Hex("01 03"), Bytes(14)}));
  EXPECT_FALSE(motion.orientation.usable);
  EXPECT_THAT(motion.orientation.rotation, ElementsAre(0, 0, 0, 1));
}

TEST(Record, GivesItsOrientationWhereItHasOne) {
  for (const Bytes& bytes : {testing::kMotionRecord, testing::kMotionAndBatteryRecord,
                             testing::kMagnetometerRecord, testing::kMotionAndButtonRecord}) {
    EXPECT_NE(OrientationOf(DecodeOne(bytes)), nullptr);
  }
  for (const Bytes& bytes : {testing::kInfoRecord, testing::kStatusRecord, testing::kRuntimeRecord,
                             testing::kButtonRecord, testing::kRegistrationRecord}) {
    EXPECT_EQ(OrientationOf(DecodeOne(bytes)), nullptr);
  }
}

TEST(Record, IsWrittenAsTheFirmwareWritesIt) {
  for (const Bytes& bytes :
       {testing::kInfoRecord, testing::kMotionAndBatteryRecord, testing::kStatusRecord,
        testing::kMagnetometerRecord, testing::kRuntimeRecord, testing::kButtonRecord,
        testing::kMotionAndButtonRecord, testing::kRegistrationRecord}) {
    EXPECT_EQ(Encode(DecodeOne(bytes)), bytes) << std::to_integer<int>(bytes[0]);
  }
  // Rounded here, cut off there: 23170.475 is the same in both.
  EXPECT_EQ(Encode(DecodeOne(testing::kMotionRecord)), testing::kMotionRecord);
}

TEST(Record, SaturatesWhatIsBeyondItsFields) {
  Motion motion;
  motion.orientation.rotation = {0, 0, 0, 1};  // 1 is beyond Q15
  motion.acceleration_mps2 = {1e9F, -1e9F, std::numeric_limits<float>::quiet_NaN()};
  EXPECT_EQ(Encode({3, motion}), testing::Hex("01 03 00 00 00 00 00 00 FF 7F FF 7F 00 80 00 00"));
  Info info;
  info.battery = {200, 9, 500};
  EXPECT_EQ(Encode({3, info}), testing::Hex("00 03 FF FF FF 00 00 00 00 00 00 00 00 00 00 00"));
}

// Worked by hand: 0.5 of the way from 1024 to 2048 is 90 of 180 degrees.
TEST(PackedRotation, HasTheWorkedValues) {
  EXPECT_EQ(Pack({0, 0, 0, 1}), 0x80100200U);
  EXPECT_EQ(Pack({0, 0, 0, -1}), 0x80100200U);
  EXPECT_EQ(Pack({0, 0, kSqrtHalf, kSqrtHalf}), 0xC0100200U);
  EXPECT_EQ(Pack({kSqrtHalf, 0, 0, kSqrtHalf}), 0x80100300U);
  EXPECT_EQ(Pack({0, -kSqrtHalf, 0, kSqrtHalf}), 0x80080200U);
  EXPECT_EQ(Pack({0, kSqrtHalf, 0, -kSqrtHalf}), 0x80080200U);  // the shorter way round
  EXPECT_LT(Degrees(Unpack(0x80100200U), {0, 0, 0, 1}), 0.01F);
  EXPECT_LT(Degrees(Unpack(0xC0100200U), {0, 0, kSqrtHalf, kSqrtHalf}), 0.01F);
}

// 0 in all three is -1, -1, -1: beyond any rotation that is sent, and still one.
TEST(PackedRotation, IsOfUnitLengthWhateverTheBits) {
  for (std::uint32_t i = 0; i < 200'000; ++i) {
    const auto q = Unpack(i * 2'654'435'761U);
    EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-5F);
  }
}

TEST(PackedRotation, APackedRotationIsReadBackWithinAStep) {
  for (int i = 0; i < 5000; ++i) {
    const auto at = [i](int k) { return std::sin(0.37F * static_cast<float>(i * (k + 3) + k)); };
    const Orientation o = MakeOrientation(at(0), at(1), at(2), at(3));
    EXPECT_LT(Degrees(Unpack(Pack(o.rotation)), o.rotation), 0.45F) << i;
  }
}

}  // namespace
}  // namespace styled::slimevr
