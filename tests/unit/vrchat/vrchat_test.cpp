#include "proto/rigs/vrchat/vrchat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/vmc/witness.h"
#include "tests/unit/vrchat/message_cases.h"

namespace styled::vrchat {
namespace {

using ::testing::ElementsAre;
using Quat = Eigen::Quaterniond;
constexpr double kRadians = std::numbers::pi / 180;

osc::Message Read(const testing::Bytes& bytes) {
  osc::Reader reader(bytes);
  osc::Message message;
  EXPECT_EQ(reader.Next(message), osc::Reader::Step::kMessage);
  return message;
}

TEST(VrChat, ReadsEveryCaseAsItIsMeant) {
  for (const auto& c : testing::MessageCases()) {
    Message message;
    EXPECT_EQ(Decode(Read(c.bytes), message), c.expected) << c.name;
    EXPECT_EQ(message.index() == 0, c.expected != DecodeResult::kOk) << c.name;
  }
}

TEST(VrChat, ReadsIndexKindAndValues) {
  Message message;
  ASSERT_EQ(Decode(Read(testing::TrackerMessage("7", "rotation", {1, -2, 3})), message),
            DecodeResult::kOk);
  EXPECT_EQ(std::get<Tracker>(message).index, 7);
  EXPECT_TRUE(std::get<Tracker>(message).is_rotation);
  EXPECT_THAT(std::get<Tracker>(message).values, ElementsAre(1, -2, 3));
  ASSERT_EQ(Decode(Read(testing::TrackerMessage("head", "position", {4, 5, 6})), message),
            DecodeResult::kOk);
  EXPECT_EQ(std::get<Tracker>(message).index, kHead);
  EXPECT_FALSE(std::get<Tracker>(message).is_rotation);
  ASSERT_EQ(Decode(Read(testing::SystemMessage("leftwrist", {1, 2, 3, 40, 50, 60})), message),
            DecodeResult::kOk);
  EXPECT_EQ(std::get<SystemPose>(message).device, System::kLeftWrist);
  EXPECT_THAT(std::get<SystemPose>(message).position, ElementsAre(1, 2, 3));
  EXPECT_THAT(std::get<SystemPose>(message).euler, ElementsAre(40, 50, 60));
}

testing::Bytes Written(const Message& message) {
  testing::Bytes bytes(512);
  osc::Writer writer(bytes);
  std::visit(
      [&writer](const auto& m) {
        if constexpr (requires { Put(m, writer); }) Put(m, writer);
      },
      message);
  EXPECT_TRUE(writer.ok());
  bytes.resize(writer.size());
  return bytes;
}

TEST(VrChat, WritesTheDocumentsBytes) {
  EXPECT_EQ(Written(Tracker{3, false, {1, 2, 3}}),
            testing::TrackerMessage("3", "position", {1, 2, 3}));
  EXPECT_EQ(Written(Tracker{kHead, true, {0, 90, 0}}),
            testing::TrackerMessage("head", "rotation", {0, 90, 0}));
  EXPECT_EQ(Written(SystemPose{System::kRightWrist, {1, 2, 3}, {4, 5, 6}}),
            testing::SystemMessage("rightwrist", {1, 2, 3, 4, 5, 6}));
}

// liblo and oscpack: they know OSC, not VRChat.
TEST(VrChat, IsReadByOthers) {
  for (int index = 0; index <= kTrackers; ++index) {
    for (const bool rotation : {false, true}) {
      const auto bytes = Written(Tracker{index, rotation, {0.1F, -2, 1e-9F}});
      const auto liblo = vmc::testing::ReadLiblo(bytes);
      ASSERT_TRUE(liblo.taken);
      EXPECT_EQ(liblo.messages, vmc::testing::ReadOurs(bytes).messages);
      EXPECT_EQ(vmc::testing::ReadOscpack(bytes).messages, liblo.messages);
      EXPECT_THAT(liblo.messages[0],
                  ::testing::StartsWith("/tracking/trackers/" +
                                        (index == 0 ? "head" : std::to_string(index)) +
                                        (rotation ? "/rotation" : "/position") + " ,fff "));
    }
  }
}

Quat Of(const std::array<float, 4>& q) { return {q[3], q[0], q[1], q[2]}; }
// By Eigen: a turn about z, then x, then y, on fixed axes.
Quat Expected(const std::array<float, 3>& euler) {
  const auto about = [](const Eigen::Vector3d& axis, float degrees) {
    return Quat(Eigen::AngleAxisd(kRadians * double{degrees}, axis));
  };
  return about(Eigen::Vector3d::UnitY(), euler[1]) * about(Eigen::Vector3d::UnitX(), euler[0]) *
         about(Eigen::Vector3d::UnitZ(), euler[2]);
}

TEST(VrChat, TurnsAboutZThenXThenY) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(-360, 360);
  for (int i = 0; i < 1000; ++i) {
    const std::array<float, 3> euler{any(random), any(random), any(random)};
    EXPECT_LT(Of(QuaternionOf(euler)).angularDistance(Expected(euler)), 1e-6);
  }
  // By hand: 90 degrees about y turn z to x (left-handed or not).
  EXPECT_LT(
      (Of(QuaternionOf({0, 90, 0})) * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(),
      1e-6);
  // 90 about x first would lift z; the turn about z comes before it.
  EXPECT_LT(
      (Of(QuaternionOf({90, 0, 90})) * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitZ()).norm(),
      1e-6);
}

TEST(VrChat, FindsTheAnglesOfEveryRotation) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    Quat q(normal(random), normal(random), normal(random), normal(random));
    if (i % 4 == 0) {  // looking straight up or down
      q = Expected({i % 8 == 0 ? 90.0F : -90.0F, static_cast<float>(i % 360), 30});
    }
    q.normalize();
    const Eigen::Vector4f c = q.coeffs().cast<float>();
    const auto euler = EulerOf({c[0], c[1], c[2], c[3]});
    for (const float angle : euler) EXPECT_LE(std::abs(angle), 180.001F);
    // Near the poles a tenth of a degree is given up.
    EXPECT_LT(Of(QuaternionOf(euler)).angularDistance(q), 0.004) << i;
  }
  EXPECT_THAT(EulerOf({0, 0, 0, 1}), ElementsAre(0, 0, 0));
}

TEST(VrChat, NamesItsResults) {
  EXPECT_EQ(Name(DecodeResult::kOk), "ok");
  EXPECT_EQ(Name(DecodeResult::kWrongType), "wrong_type");
  EXPECT_EQ(Name(DecodeResult::kCount), "unknown");
}

}  // namespace
}  // namespace styled::vrchat
