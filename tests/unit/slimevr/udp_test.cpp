#include "proto/rigs/slimevr/udp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "tests/unit/slimevr/decode_cases.h"

namespace styled::slimevr {
namespace {

using testing::Bytes;
using ::testing::ElementsAre;
using ::testing::FloatNear;
using testing::Header;
using testing::Hex;
using testing::Join;

constexpr float kHalfRoot = 0.70710678F;

std::unique_ptr<Datagram> DecodeAll(const Bytes& bytes) {
  auto datagram = std::make_unique<Datagram>();
  EXPECT_EQ(Name(Decode(bytes, *datagram)), "ok");
  return datagram;
}

template <typename T>
T DecodeAs(const Bytes& bytes) {
  const auto datagram = DecodeAll(bytes);
  EXPECT_EQ(datagram->count, 1U);
  const T* body = std::get_if<T>(&datagram->packets[0]);
  if (body == nullptr) {
    ADD_FAILURE() << "another type";
    return {};
  }
  return *body;
}

Bytes EncodeOne(std::uint64_t number, const Packet& packet) {
  Bytes bytes(kMaxUdpSize);
  bytes.resize(Encode(number, packet, bytes));
  return bytes;
}

template <typename T>
T AnswerAs(const Bytes& bytes) {
  Answer answer;
  EXPECT_EQ(Name(DecodeAnswer(bytes, answer)), "ok");
  const T* body = std::get_if<T>(&answer);
  if (body == nullptr) {
    ADD_FAILURE() << "another answer";
    return {};
  }
  return *body;
}

Bytes EncodeOne(const Answer& answer) {
  Bytes bytes(kMaxAnswerSize);
  bytes.resize(EncodeAnswer(answer, bytes));
  return bytes;
}

TEST(Udp, EveryCaseOfTheTableGivesItsReason) {
  Datagram datagram;
  for (const auto& c : testing::UdpCases()) {
    EXPECT_EQ(Name(Decode(c.bytes, datagram)), Name(c.expected)) << c.name;
  }
}

TEST(Udp, EveryReasonOfADatagramIsReachedByTheTable) {
  for (const UdpResult reason :
       {UdpResult::kOk, UdpResult::kTooShort, UdpResult::kTooDeep, UdpResult::kTooMany}) {
    const auto cases = testing::UdpCases();
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [reason](const auto& c) {
      return c.expected == reason;
    })) << Name(reason);
  }
}

TEST(Udp, PassesOverTypesToComeAndCountsThem) {
  const auto datagram = DecodeAll(Join({Header("1C", "04"), Bytes(16)}));
  EXPECT_EQ(datagram->number, 4U);
  EXPECT_EQ(datagram->count, 0U);
  EXPECT_EQ(datagram->unknown, 1U);
}

TEST(Udp, ReadsAHandshakeAsTheFirmwareWritesIt) {
  const auto bytes = testing::kHandshake;
  const auto handshake = DecodeAs<Handshake>(bytes);
  EXPECT_EQ(handshake.board, 9U);
  EXPECT_EQ(handshake.imu, 4U);
  EXPECT_EQ(handshake.mcu, 1U);
  EXPECT_EQ(handshake.protocol, 22U);
  EXPECT_EQ(handshake.firmware, "0.7.2");
  EXPECT_THAT(handshake.mac, ElementsAre(0xA8, 0x48, 0xFA, 0xC0, 0x1D, 0x42));
}

TEST(Udp, ReadsWhatIsThereOfAnOldHandshake) {
  const auto none = DecodeAs<Handshake>(Header("03", "00"));
  EXPECT_EQ(none.board, 0U);
  EXPECT_TRUE(none.firmware.empty());
  EXPECT_THAT(none.mac, ElementsAre(0, 0, 0, 0, 0, 0));
  const auto some = DecodeAs<Handshake>(Join({Header("03", "00"), Hex("00 00 00 03 00 00 00 06")}));
  EXPECT_EQ(some.board, 3U);
  EXPECT_EQ(some.imu, 6U);
  EXPECT_EQ(some.mcu, 0U);
}

TEST(Udp, ReadsARotationAsTheFirmwareWritesIt) {
  const auto rotation = DecodeAs<Rotation>(testing::kRotation);
  EXPECT_EQ(rotation.sensor, 1);
  EXPECT_EQ(rotation.kind, 1);
  EXPECT_EQ(rotation.accuracy, 2);
  EXPECT_TRUE(rotation.orientation.usable);
  EXPECT_THAT(rotation.orientation.rotation, ElementsAre(0.5F, 0.5F, -0.5F, 0.5F));
}

TEST(Udp, ReadsBothLegacyRotationsByTheirTypes) {
  const Bytes body = Hex("3F 80 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
  EXPECT_EQ(DecodeAs<LegacyRotation>(Join({Header("01", "01"), body})).sensor, 0);
  const auto second = DecodeAs<LegacyRotation>(Join({Header("10", "01"), body}));
  EXPECT_EQ(second.sensor, 1);
  EXPECT_THAT(second.orientation.rotation, ElementsAre(1, 0, 0, 0));
}

// The server takes NaN and zeros for identity; so is it here, and said to be nothing measured.
TEST(Udp, TakesARotationThatIsNoneForIdentity) {
  const std::initializer_list<std::string_view> none{
      "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00",
      "7F C0 00 00 00 00 00 00 00 00 00 00 3F 80 00 00",
      "00 00 00 00 00 00 00 00 00 00 00 00 7F 80 00 00"};
  for (const std::string_view body : none) {
    const auto rotation = DecodeAs<Rotation>(Join({Header("11", "01"), Hex("00 01"), Hex(body)}));
    EXPECT_FALSE(rotation.orientation.usable) << body;
    EXPECT_THAT(rotation.orientation.rotation, ElementsAre(0, 0, 0, 1)) << body;
  }
}

TEST(Udp, BringsARotationToUnitLength) {
  const auto rotation = DecodeAs<Rotation>(
      Join({Header("11", "01"), Hex("00 01 00 00 00 00 40 00 00 00 00 00 00 00 00 00 00 00 00")}));
  EXPECT_TRUE(rotation.orientation.usable);
  EXPECT_THAT(rotation.orientation.rotation, ElementsAre(0, 1, 0, 0));
}

TEST(Udp, ReadsSensorInfoOfOldAndNewFirmware) {
  const auto info = DecodeAs<SensorInfo>(testing::kSensorInfo);
  EXPECT_EQ(info.sensor, 1);
  EXPECT_EQ(info.status, 1);
  EXPECT_EQ(info.imu, 13);
  EXPECT_EQ(info.config, 3);
  EXPECT_EQ(info.calibrated, 1);
  EXPECT_EQ(info.position, 15);
  EXPECT_EQ(info.data, 0);
  const auto old = DecodeAs<SensorInfo>(Join({Header("0F", "05"), Hex("01 02 07")}));
  EXPECT_EQ(old.status, 2);
  EXPECT_EQ(old.imu, 7);
  EXPECT_EQ(old.position, 0);
}

TEST(Udp, ReadsCompactMotion) {
  const auto motion =
      DecodeAs<RotationAndAcceleration>(Join({Header("17", "03"), testing::kMotionBody}));
  EXPECT_EQ(motion.sensor, 2);
  EXPECT_THAT(motion.motion.orientation.rotation,
              ElementsAre(0, 0, FloatNear(kHalfRoot, 1e-6F), FloatNear(kHalfRoot, 1e-6F)));
  EXPECT_THAT(motion.motion.acceleration_mps2, ElementsAre(0, -1, FloatNear(9.80665F, 0.01F)));
}

TEST(Udp, ReadsTheSmallPackets) {
  const auto acceleration = DecodeAs<Acceleration>(
      Join({Header("04", "01"), Hex("3F 80 00 00 C0 00 00 00 7F C0 00 00")}));
  EXPECT_THAT(acceleration.acceleration_mps2, ElementsAre(1, -2, 0));
  EXPECT_EQ(acceleration.sensor, 0);
  EXPECT_EQ(DecodeAs<Ping>(Join({Header("0A", "00"), Hex("CA FE BA BE")})).id, 0xCAFEBABEU);
  const Bytes hi = Join({Header("0B", "01"), Hex("00 00 00 02 68 69")});
  const auto text = DecodeAll(hi);
  EXPECT_EQ(std::get<Text>(text->packets[0]).text, "hi");
  const auto level = DecodeAs<BatteryLevel>(Join({Header("0C", "01"), Hex("3F 40 00 00")}));
  EXPECT_EQ(level.volts, 0);
  EXPECT_EQ(level.level, 0.75F);
  const auto both =
      DecodeAs<BatteryLevel>(Join({Header("0C", "01"), Hex("40 80 00 00 3F 40 00 00")}));
  EXPECT_EQ(both.volts, 4);
  EXPECT_EQ(both.level, 0.75F);
  EXPECT_EQ(DecodeAs<SignalStrength>(Join({Header("13", "01"), Hex("FF C4")})).dbm, -60);
  EXPECT_EQ(DecodeAs<Temperature>(Join({Header("14", "01"), Hex("01 41 F8 00 00")})).celsius, 31);
  EXPECT_EQ(DecodeAs<Temperature>(Join({Header("14", "01"), Hex("01")})).celsius, 0);
  EXPECT_EQ(DecodeAs<UserAction>(Join({Header("15", "01"), Hex("03")})).action,
            UserAction::kYawReset);
  EXPECT_EQ(DecodeAs<FeatureFlags>(Join({Header("16", "01"), Hex("06 01")})).bits, 0x0106U);
  EXPECT_EQ(DecodeAs<ConfigAck>(Join({Header("18", "01"), Hex("FF 00 01")})).what, 1);
  EXPECT_EQ(DecodeAs<ProtocolChange>(Join({Header("C8", "01"), Hex("02 05")})).version, 5);
}

TEST(Udp, ReadsABundleAsTheFirmwareWritesIt) {
  const auto datagram = DecodeAll(testing::kBundle);
  EXPECT_EQ(datagram->number, 9U);
  ASSERT_EQ(datagram->count, 2U);
  EXPECT_EQ(std::get<Rotation>(datagram->packets[0]).sensor, 1);
  EXPECT_EQ(std::get<Acceleration>(datagram->packets[1]).sensor, 1);
}

TEST(Udp, ReadsACompactBundle) {
  const auto datagram = DecodeAll(testing::kCompactBundle);
  EXPECT_EQ(datagram->number, 10U);
  ASSERT_EQ(datagram->count, 2U);
  EXPECT_EQ(std::get<RotationAndAcceleration>(datagram->packets[0]).sensor, 2);
  EXPECT_EQ(std::get<Tap>(datagram->packets[1]).value, 2);
}

TEST(Udp, KeepsThePacketsBesideAnUnknownOneInABundle) {
  const auto datagram =
      DecodeAll(Join({Header("65", "01"), Hex("04 1C 00 00 00 03 0D 01 02 00 01 00")}));
  ASSERT_EQ(datagram->count, 2U);
  EXPECT_EQ(datagram->unknown, 1U);
  EXPECT_EQ(std::get<Tap>(datagram->packets[0]).sensor, 1);
}

TEST(Udp, WritesWhatTheFirmwareWrites) {
  EXPECT_EQ(EncodeOne(7, DecodeAll(testing::kRotation)->packets[0]), testing::kRotation);
  EXPECT_EQ(EncodeOne(3, DecodeAs<RotationAndAcceleration>(
                             Join({Header("17", "03"), testing::kMotionBody}))),
            Join({Header("17", "03"), testing::kMotionBody}));
  // Less the tail of newer firmware.
  const auto handshake = EncodeOne(0, DecodeAs<Handshake>(testing::kHandshake));
  EXPECT_EQ(handshake, Bytes(testing::kHandshake.begin(), testing::kHandshake.end() - 20));
  const auto info = EncodeOne(5, DecodeAs<SensorInfo>(testing::kSensorInfo));
  EXPECT_EQ(info, Bytes(testing::kSensorInfo.begin(), testing::kSensorInfo.end() - 8));
}

TEST(Udp, WritesBundlesAsTheFirmwareDoes) {
  Bytes out(kMaxUdpSize);
  const auto bundle = DecodeAll(testing::kBundle);
  out.resize(EncodeBundle(9, std::span(bundle->packets).first(2), false, out));
  EXPECT_EQ(out, testing::kBundle);
  out.resize(kMaxUdpSize);
  const auto compact = DecodeAll(testing::kCompactBundle);
  out.resize(EncodeBundle(10, std::span(compact->packets).first(2), true, out));
  EXPECT_EQ(out, testing::kCompactBundle);
}

// Fixed fields that no reading shows: what is written is read again, type by type.
TEST(Udp, ReadsAgainWhatItWrites) {
  for (const auto& c : testing::UdpCases()) {
    Datagram first, second;
    if (Decode(c.bytes, first) != UdpResult::kOk) continue;
    for (std::size_t i = 0; i < first.count; ++i) {
      const Bytes bytes = EncodeOne(first.number, first.packets[i]);
      ASSERT_EQ(Decode(bytes, second), UdpResult::kOk) << c.name;
      ASSERT_EQ(second.count, 1U) << c.name;
      EXPECT_EQ(second.packets[0].index(), first.packets[i].index()) << c.name;
      EXPECT_EQ(EncodeOne(second.number, second.packets[0]), bytes) << c.name;
    }
  }
}

TEST(Udp, WritesNothingThatDoesNotFit) {
  Bytes out(testing::kRotation.size() - 1);
  EXPECT_EQ(Encode(7, Rotation{}, out), 0U);
  const Packet text = Text{std::string_view("long").substr(0, 4)};
  EXPECT_EQ(EncodeBundle(7, std::span(&text, 1), false, std::span(out).first(20)), 0U);
  const std::string longer(300, 'x');
  const Packet too_long = Text{longer};
  Bytes room(kMaxUdpSize);
  EXPECT_EQ(EncodeBundle(7, std::span(&too_long, 1), true, room), 0U);
  EXPECT_NE(EncodeBundle(7, std::span(&too_long, 1), false, room), 0U);
}

// The firmware compares 12 characters behind the first byte; old servers pad to 64 bytes.
TEST(UdpAnswer, ToAHandshakeIsTheServersGreeting) {
  const Bytes greeting = EncodeOne(Greeting{});
  EXPECT_EQ(greeting, Hex("03 48 65 79 20 4F 56 52 20 3D 44 20 35"));
  AnswerAs<Greeting>(greeting);
  AnswerAs<Greeting>(Join({greeting, Bytes(51)}));
}

TEST(UdpAnswer, IsWrittenAsTheServerWritesIt) {
  EXPECT_EQ(EncodeOne(Heartbeat{}), Header("01", "00"));
  EXPECT_EQ(EncodeOne(Ping{0x12345678}), Join({Header("0A", "00"), Hex("12 34 56 78")}));
  EXPECT_EQ(EncodeOne(FeatureFlags{kBundles | kCompactBundles}),
            Join({Header("16", "00"), Hex("03")}));
  EXPECT_EQ(EncodeOne(SensorInfoAck{2, 1}), Hex("00 00 00 0F 02 01"));
  EXPECT_EQ(EncodeOne(SetConfig{255, 1, 1}), Join({Header("19", "00"), Hex("FF 00 01 01")}));
}

TEST(UdpAnswer, EncodedValuesAreDecodedUnchanged) {
  EXPECT_EQ(AnswerAs<Ping>(EncodeOne(Ping{77})).id, 77U);
  EXPECT_EQ(AnswerAs<FeatureFlags>(EncodeOne(FeatureFlags{3})).bits, 3U);
  EXPECT_EQ(AnswerAs<SensorInfoAck>(EncodeOne(SensorInfoAck{2, 1})).sensor, 2);
  EXPECT_EQ(AnswerAs<SetConfig>(EncodeOne(SetConfig{1, 2, 1})).what, 2);
  AnswerAs<Heartbeat>(EncodeOne(Heartbeat{}));
}

TEST(UdpAnswer, AnInvalidAnswerIsRefusedAndLeavesTheLastAlone) {
  Answer answer = Ping{5};
  EXPECT_EQ(DecodeAnswer({}, answer), UdpResult::kTooShort);
  EXPECT_EQ(DecodeAnswer(Hex("03 48 65 79"), answer), UdpResult::kTooShort);
  EXPECT_EQ(DecodeAnswer(Hex("00 00 00 0F 02"), answer), UdpResult::kTooShort);
  EXPECT_EQ(DecodeAnswer(Join({Header("0A", "00"), Hex("12 34")}), answer), UdpResult::kTooShort);
  EXPECT_EQ(DecodeAnswer(Join({Header("19", "00"), Hex("FF 00 01")}), answer),
            UdpResult::kTooShort);
  EXPECT_EQ(DecodeAnswer(Header("11", "00"), answer), UdpResult::kNoAnswer);
  EXPECT_EQ(std::get<Ping>(answer).id, 5U);
}

TEST(UdpAnswer, IsNotWrittenWhereItDoesNotFit) {
  Bytes out(12);
  EXPECT_EQ(EncodeAnswer(Greeting{}, out), 0U);
  EXPECT_EQ(EncodeAnswer(Ping{}, out), 0U);
  EXPECT_EQ(EncodeAnswer(Heartbeat{}, out), 12U);
}

}  // namespace
}  // namespace styled::slimevr
