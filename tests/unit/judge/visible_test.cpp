#include "model/train/judge/visible.h"

#include <gtest/gtest.h>

#include "tests/unit/judge/walk.h"

namespace styled::judge {
namespace {

// The same, with this turn of a joint on top of its own.
std::vector<body::Pose> Turned(std::vector<body::Pose> poses, int joint, const body::Vec3& turn) {
  for (body::Pose& pose : poses) {
    body::Quat& rotation = pose.rotations[static_cast<std::size_t>(joint)];
    rotation = rotation * body::Exp(turn);
  }
  return poses;
}

TEST(MeasureVisible, IsHowFarEachLimbIsFromThePerformers) {
  const auto input = Walk(0.3F);
  const auto output = Turned(input, body::kLeftLowerArm, {0, 0, 0.5F});
  const Visible visible = MeasureVisible(input, output);
  EXPECT_NEAR(visible.turned_deg.value(), 0.5 * 57.296 / body::kJointCount, 1e-3);
  // One of two hands, by the chord of 0.25 m.
  EXPECT_NEAR(visible.moved_cm[1].value(), 0.5 * 2 * 25 * std::sin(0.25), 0.01);
  for (const std::size_t limb : {0U, 2U, 3U, 4U})
    EXPECT_NEAR(visible.moved_cm[limb].value(), 0, 1e-3);
  EXPECT_NEAR(visible.all_cm.value(), visible.moved_cm[1].value() * 2 / 9, 1e-3);
  EXPECT_EQ(visible.most_cm(), visible.moved_cm[1].value());
}

TEST(MeasureVisible, TheWayOverTheFloorIsNoStyle) {
  const auto input = Walk(0);
  auto output = input;
  for (body::Pose& pose : output) pose.hips_position_m *= 1.0F;
  for (std::size_t i = 0; i < output.size(); ++i) {
    output[i].hips_position_m.z() += 0.01F * static_cast<float>(i);
  }
  EXPECT_NEAR(MeasureVisible(input, output).all_cm.value(), 0, 1e-3);
}

train::TrainingClip SeenClip(int style, int content, std::vector<body::Pose> poses) {
  train::TrainingClip clip;
  clip.style = style;
  clip.content = content;
  clip.poses = std::move(poses);
  return clip;
}

TEST(ClassifyByDirection, ARealStyleIsToldWhoeverShowsIt) {
  constexpr int kWalk = 0, kRun = 1;
  const body::Vec3 stoop(0.4F, 0, 0), chin_up(-0.2F, 0, 0);
  std::vector<train::TrainingClip> clips;
  clips.push_back(SeenClip(0, kWalk, Walk(0)));
  clips.push_back(SeenClip(1, kWalk, Turned(Walk(1), body::kSpine, stoop)));
  clips.push_back(SeenClip(2, kWalk, Turned(Walk(2), body::kHead, chin_up)));
  clips.push_back(SeenClip(3, kRun, Walk(2)));
  std::vector<Eigen::VectorXd> real;
  for (const int style : {1, 2, 3}) real.push_back(RealShift(clips, style, kWalk));
  ASSERT_EQ(real[0].size(), 3 * body::kJointCount);
  EXPECT_NEAR(real[0][3 * body::kSpine], 0.4, 0.01);
  EXPECT_EQ(real[2].size(), 0) << "nobody walks in it";
  const auto input = Walk(0.7F, 1.1F, 0.9F);
  const auto told = [&](const std::vector<body::Pose>& output) {
    return ClassifyByDirection(MeasureShift(input, output), real);
  };
  EXPECT_EQ(told(Turned(input, body::kSpine, 0.3F * stoop)), 0) << "a third of it";
  EXPECT_EQ(told(Turned(input, body::kHead, 2 * chin_up)), 1);
  EXPECT_EQ(told(input), -1) << "nothing is changed";
}

}  // namespace
}  // namespace styled::judge
