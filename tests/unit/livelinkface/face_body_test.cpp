// A face alone as a performer.
#include "daemon/source/rigs/face_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "daemon/source/rigs/live_link_face.h"
#include "model/base/text.h"
#include "tests/support/translation.h"
#include "tests/unit/livelinkface/decode_cases.h"
#include "tests/unit/livelinkface/recording.h"

namespace styled::source {
namespace {

using live_link_face::testing::ReadRecording;
using live_link_face::testing::Smile;
using live_link_face::testing::Written;
using support::Said;
using support::Translated;

constexpr std::size_t kYaw = arkit::kShapes, kPitch = kYaw + 1, kRoll = kYaw + 2;
constexpr float kDegree = 57.29578F;

config::Source Alone(std::string body = "standing") {
  config::Source config;
  config.name = "phone";
  config.type = "livelinkface";
  config.body = std::move(body);
  return config;
}

body::WorldPose World(const body::Pose& pose) {
  body::WorldPose world;
  body::ForwardKinematics(pose, world);
  return world;
}

// The canonical poses of the datagrams, in order.
class Performer {
 public:
  explicit Performer(const config::Source& config) : translated_(MakeLiveLinkFace(config)) {}
  std::optional<body::Pose> Pose(const live_link_face::Frame& frame) {
    return Pose(Written(frame));
  }
  std::optional<body::Pose> Pose(const std::vector<std::byte>& datagram) {
    std::optional<body::Pose> pose;
    for (const auto& item : Said(translated_, datagram)) {
      if (!item.is_frame) {
        body_ = item.body;
      } else {
        last_ = item.frame;
        pose = support::CanonicalPose(body_, item.frame);
      }
    }
    return pose;
  }
  Translated& translated() { return translated_; }
  const v1::Body& body() const { return body_; }
  const v1::SourceFrame& last() const { return last_; }

 private:
  Translated translated_;
  v1::Body body_;
  v1::SourceFrame last_;
};

// In the world the head looks where the phone's angles say, by the cosines of a direction instead
// of by the code's quaternions.
TEST(FaceBody, TheHeadOfARealTakeIsThePhones) {
  const auto datagrams = ReadRecording("dao.gesichter", STYLED_DATA_DEFAULT);
  if (datagrams.empty()) GTEST_SKIP() << "skipped, no data";
  Performer performer(Alone());
  float worst_deg = 0, turned_deg = 0, resting_deg = 0;
  for (const auto& datagram : datagrams) {
    const auto pose = performer.Pose(datagram);
    ASSERT_TRUE(pose);
    live_link_face::Frame frame;
    ASSERT_EQ(live_link_face::Decode(datagram, frame), live_link_face::DecodeResult::kOk);
    const float yaw = frame.values[kYaw], up = frame.values[kPitch], roll = -frame.values[kRoll];
    const body::Quat& head = World(*pose).rotations[body::kHead];
    const body::Vec3 ahead(std::sin(yaw) * std::cos(up), std::sin(up),
                           std::cos(yaw) * std::cos(up));
    worst_deg = std::max(
        worst_deg, kDegree * std::acos(std::min(1.0F, ahead.dot(head * body::Vec3::UnitZ()))));
    // The left ear's height shows the roll: sin(roll) cos(pitch).
    const float ear = (head * body::Vec3::UnitX()).y();
    EXPECT_NEAR(ear, std::sin(roll) * std::cos(up), 0.01F);
    turned_deg = std::max(turned_deg, kDegree * std::abs(yaw));
    resting_deg = std::max(resting_deg, kDegree * std::acos(std::min(1.0F, ahead.z())));
  }
  EXPECT_LT(worst_deg, 0.2F) << "expected the phone's head within a degree";
  EXPECT_GT(turned_deg, 15) << "the performer of the take turns their head";
  EXPECT_GT(resting_deg, 15) << "a head that stays still would be wrong by this";
}

TEST(FaceBody, StandsOrSitsOnTheFloorWithHangingArms) {
  for (const bool seated : {false, true}) {
    Performer performer(Alone(seated ? "seated" : "standing"));
    const auto pose = performer.Pose(Smile());
    ASSERT_TRUE(pose);
    const body::WorldPose world = World(*pose);
    for (const int foot : {int{body::kLeftFoot}, int{body::kRightFoot}}) {
      const auto at = static_cast<std::size_t>(foot);
      EXPECT_NEAR(world.positions_m[at].y(), 0.09F, 0.005F);
      EXPECT_LT(body::Log(world.rotations[at]).norm(), 1e-3F) << "soles on the floor";
    }
    EXPECT_NEAR(world.positions_m[body::kHips].y(), seated ? 0.6F : 0.98F, 0.03F);
    for (const auto& [hand, shoulder] : {std::pair{body::kLeftHand, body::kLeftUpperArm},
                                         {body::kRightHand, body::kRightUpperArm}}) {
      EXPECT_LT(world.positions_m[hand].y(),
                world.positions_m[shoulder].y() - (seated ? 0.2F : 0.4F));
      EXPECT_GT(world.positions_m[hand].z(), world.positions_m[shoulder].z());
    }
    EXPECT_LT(world.positions_m[body::kRightHand].x(), world.positions_m[body::kLeftHand].x());
  }
}

TEST(FaceBody, ItsNameIsTheSourcesOrTheConfigured) {
  Performer performer(Alone());
  (void)performer.Pose(Smile());
  EXPECT_EQ(performer.body().performer(), "phone");
  config::Source named = Alone();
  named.performer = "anna";
  Performer anna(named);
  (void)anna.Pose(Smile());
  EXPECT_EQ(anna.body().performer(), "anna");
}

TEST(FaceBody, EyesFollowTheGazeAndExpressionsAreSent) {
  Performer performer(Alone());
  live_link_face::Frame frame = Smile();
  frame.values[*arkit::Find("eyeLookOutLeft")] = 0.5F;
  frame.values[*arkit::Find("eyeLookInRight")] = 0.5F;
  frame.values[*arkit::Find("eyeLookDownLeft")] = 0.25F;
  frame.values[*arkit::Find("eyeLookDownRight")] = 0.25F;
  ASSERT_TRUE(performer.Pose(frame));
  const auto& rotations = performer.last().rotations();
  ASSERT_EQ(rotations.size(), 4 * 23);
  for (const int eye : {21, 22}) {
    EXPECT_EQ(performer.body().names(eye), eye == 21 ? "leftEye" : "rightEye");
    const body::Quat turn(rotations[4 * eye + 3], rotations[4 * eye], rotations[4 * eye + 1],
                          rotations[4 * eye + 2]);
    const body::Vec3 gaze = turn * body::Vec3::UnitZ();
    EXPECT_NEAR(kDegree * std::asin(gaze.x()), 17, 1) << "to the performer's left";
    EXPECT_NEAR(kDegree * std::asin(gaze.y()), -8.7F, 1) << "down";
  }
  EXPECT_EQ(performer.last().expressions_size(), static_cast<int>(arkit::kShapes));
}

TEST(FaceBody, AbsurdAnglesLeaveTheHeadAsItIs) {
  Performer performer(Alone());
  live_link_face::Frame frame = Smile(1);
  frame.values[kYaw] = 0.3F;
  const auto before = performer.Pose(frame);
  ASSERT_TRUE(before);
  for (const float absurd :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30F}) {
    ++frame.frame;
    frame.values[kYaw] = absurd;
    const auto pose = performer.Pose(frame);
    ASSERT_TRUE(pose);
    EXPECT_EQ(support::Between(*before, *pose).joint_deg, 0);
  }
}

TEST(FaceBody, ACalibrationMakesThePresentHeadLookAhead) {
  Performer performer(Alone());
  live_link_face::Frame frame = Smile(1);
  frame.values[kYaw] = 0.2F;
  frame.values[kPitch] = -0.4F;  // a phone below the screen
  (void)performer.Pose(frame);
  Translator& translator = performer.translated().translator();
  EXPECT_TRUE(translator.has_sensors());
  EXPECT_FALSE(translator.Calibrate(Calibration::kMounting, 0).ok());
  const auto head = [&] {
    ++frame.frame;
    return body::Log(World(*performer.Pose(frame)).rotations[body::kHead]);
  };
  ASSERT_TRUE(translator.Calibrate(Calibration::kYaw, 0).ok());
  EXPECT_NEAR(head().y(), 0, 1e-3F);
  EXPECT_NEAR(head().x(), 0.4F, 1e-3F) << "still down";
  ASSERT_TRUE(translator.Calibrate(Calibration::kFull, 0).ok());
  EXPECT_LT(head().norm(), 1e-3F);
  Translated merged(MakeLiveLinkFace([] {
    config::Source config = Alone("none");
    config.merge_into = "stage.anna";
    return config;
  }()));
  EXPECT_FALSE(merged.translator().has_sensors());
}

TEST(FaceBody, ALostFrameIsCountedAndARestartIsANewSession) {
  Translated translation(MakeLiveLinkFace(Alone()));
  const auto first = Said(translation, Written(Smile(1000)));
  ASSERT_EQ(first.size(), 2U) << "body and frame";
  const auto next = Said(translation, Written(Smile(1003)));
  ASSERT_EQ(next.size(), 1U);
  EXPECT_EQ(next[0].sequence, first[1].sequence + 3);
  const auto again = Said(translation, Written(Smile(5)));
  ASSERT_EQ(again.size(), 2U);
  EXPECT_NE(again[1].session, first[1].session);
}

TEST(FaceBody, DoesNotAllocate) {
  const auto translator = MakeLiveLinkFace(Alone());
  (void)support::Allocations(*translator, Written(Smile(1)), 1);
  EXPECT_EQ(support::Allocations(*translator, Written(Smile(2)), 2), 0);
}

}  // namespace
}  // namespace styled::source
