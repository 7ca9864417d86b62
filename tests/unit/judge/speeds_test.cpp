#include "model/train/judge/speeds.h"

#include <gtest/gtest.h>

#include "tests/unit/judge/walk.h"

namespace styled::judge {
namespace {

constexpr int kWalks = 0, kRuns = 1, kTurns = 2;

train::TrainingClip SpeedClip(int style, int content, std::vector<body::Pose> poses) {
  train::TrainingClip clip;
  clip.style = style;
  clip.content = content;
  clip.poses = std::move(poses);
  return clip;
}

// A foot is counted as ahead a little after it passes, at the same phase in every step: what is
// left is a frame at each end of some ten steps.
constexpr double kNear_spm = 2;

TEST(MeasureSpeeds, IsTheMeanOverTheClipsOfAStyleAndContent) {
  clip::Manifest manifest;
  manifest.styles = {{"neutral", {}, {}}, {"brisk", {}, {}}, {"absent", {}, {}}};
  manifest.contents = {"walk", "run", "turn"};
  std::vector<train::TrainingClip> clips;
  clips.push_back(SpeedClip(0, kWalks, Walk(0, 0.8F, 1)));
  clips.push_back(SpeedClip(0, kWalks, Walk(1, 1, 1.4F)));
  clips.push_back(SpeedClip(0, kTurns, Walk(0, 2, 9)));  // neither walk nor run
  clips.push_back(SpeedClip(0, kRuns, Walk(0, 1.4F, 3)));
  clips.push_back(SpeedClip(1, kWalks, Walk(2, 1.1F, 1.5F)));
  clips.push_back(SpeedClip(1, kRuns, std::vector<body::Pose>(30)));  // too short for either figure
  const std::vector<StyleSpeeds> speeds = MeasureSpeeds(manifest, clips, kRate_hz);
  ASSERT_EQ(speeds.size(), 3U);
  EXPECT_EQ(speeds[0].style, "neutral");
  EXPECT_NEAR(speeds[0].walk_mps, 1.2, 0.02);
  EXPECT_NEAR(speeds[0].walk_spm, (96 + 120) / 2.0, kNear_spm);
  EXPECT_NEAR(speeds[0].run_mps, 3, 0.05);
  EXPECT_NEAR(speeds[0].run_spm, 168, kNear_spm);
  EXPECT_EQ(speeds[1].style, "brisk");
  EXPECT_NEAR(speeds[1].walk_spm, 132, kNear_spm);
  EXPECT_EQ(speeds[1].run_mps, 0);
  EXPECT_EQ(speeds[1].run_spm, 0);
  EXPECT_EQ(speeds[2].walk_mps, 0);
  EXPECT_EQ(speeds[2].walk_spm, 0);
}

// Without steps there is a speed and no cadence.
TEST(MeasureSpeeds, AClipWithoutStepsHasNoCadence) {
  clip::Manifest manifest;
  manifest.styles = {{"neutral", {}, {}}};
  manifest.contents = {"walk"};
  std::vector<body::Pose> glide(240);
  for (std::size_t i = 0; i < glide.size(); ++i) {
    glide[i].hips_position_m = {0, 0.9F, static_cast<float>(i) / 60};
  }
  const std::vector<train::TrainingClip> clips{SpeedClip(0, kWalks, std::move(glide))};
  const std::vector<StyleSpeeds> speeds = MeasureSpeeds(manifest, clips, kRate_hz);
  EXPECT_NEAR(speeds[0].walk_mps, 1, 0.02);
  EXPECT_EQ(speeds[0].walk_spm, 0);
}

}  // namespace
}  // namespace styled::judge
