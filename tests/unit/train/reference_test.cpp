#include "model/train/reference.h"

#include <gtest/gtest.h>

#include <span>
#include <vector>

#include "tests/unit/body/random_pose.h"
#include "tests/unit/judge/walk.h"

namespace styled::train {
namespace {

using judge::kRate_hz;
using judge::kStrides_hz;
using judge::Walk;

TrainingClip Clip(int style, std::vector<body::Pose> poses) {
  TrainingClip clip;
  clip.style = style;
  clip.poses = std::move(poses);
  return clip;
}

// The walk's, with a stoop and a turn of the left foot that has no mirror image.
std::vector<body::Pose> Stooped(std::vector<body::Pose> poses) {
  for (body::Pose& pose : poses) {
    pose.rotations[body::kSpine] = body::Exp(body::Vec3(0.2F, 0, 0));
    pose.rotations[body::kLeftFoot] = body::Exp(body::Vec3(0, 0.1F, 0));
  }
  return poses;
}

std::vector<body::Pose> Standing() {
  auto poses = Walk(0, 0, 0);
  for (body::Pose& pose : poses) pose.rotations[body::kHead] = body::Exp(body::Vec3(0.3F, 0, 0));
  return poses;
}

TEST(MeasureReference, IsTheMeanOfWhoStandsAndOfWhoWalksInNeutral) {
  std::vector<TrainingClip> clips;
  clips.push_back(Clip(0, Stooped(Walk(0.7F))));
  clips.push_back(Clip(0, Standing()));
  auto run = Walk(0, kStrides_hz, 3.2F);
  for (body::Pose& pose : run) pose.rotations[body::kSpine] = body::Exp(body::Vec3(-0.1F, 0, 0));
  clips.push_back(Clip(0, run));
  auto other = Walk(0);
  for (body::Pose& pose : other) pose.rotations[body::kNeck] = body::Exp(body::Vec3(1, 0, 0));
  clips.push_back(Clip(1, other));  // another style tells nothing
  const auto reference = MeasureReference(clips, kRate_hz);
  ASSERT_TRUE(reference);
  const auto angle = [](const neutral::Carriage& of, int joint, const body::Vec3& expected) {
    return body::Angle_rad(of.rotations[static_cast<std::size_t>(joint)], body::Exp(expected));
  };
  EXPECT_LT(angle(reference->walking, body::kSpine, {0.2F, 0, 0}), 0.01);
  EXPECT_LT(angle(reference->standing, body::kSpine, {0, 0, 0}), 0.02);
  EXPECT_LT(angle(reference->running, body::kSpine, {-0.1F, 0, 0}), 0.02);
  EXPECT_LT(angle(reference->standing, body::kHead, {0.3F, 0, 0}), 0.01);
  EXPECT_LT(angle(reference->walking, body::kNeck, {0, 0, 0}), 1e-3);
  EXPECT_LT(angle(reference->walking, body::kHips, {0, 0, 0}), 0.02) << "against the heading";
  EXPECT_LT(angle(reference->walking, body::kLeftFoot, {0, 0.05F, 0}), 0.01) << "symmetric";
  EXPECT_LT(angle(reference->walking, body::kRightFoot, {0, -0.05F, 0}), 0.01);
  // A person who stands with bent elbows shows something: their arms are those of walking.
  const auto arm = static_cast<std::size_t>(body::kLeftUpperArm);
  EXPECT_TRUE(reference->standing.rotations[arm].isApprox(body::Exp({0, 0, -1.57F}), 0.05F));
}

TEST(MeasureReference, NeedsBoth) {
  std::vector<TrainingClip> clips;
  clips.push_back(Clip(0, Walk(0)));
  EXPECT_FALSE(MeasureReference(std::span(clips).first(0), kRate_hz));
  clips[0].style = 1;
  EXPECT_FALSE(MeasureReference(clips, kRate_hz));
}

}  // namespace
}  // namespace styled::train
