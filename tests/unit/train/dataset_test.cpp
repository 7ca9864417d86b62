#include "model/train/dataset.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/train/walker.h"

namespace styled::train {
namespace {

std::vector<float> Window(const TrainingClip& clip, int start, int length, bool mirrored,
                          bool session_start) {
  std::vector<float> features(static_cast<std::size_t>(length) * body::kFeatureCount);
  FillWindow(clip, start, length, mirrored, session_start, {}, {.features = features.data()});
  return features;
}

// The same frames, whether the stream is computed as a whole or a window is cut out of it.
TEST(Dataset, AWindowContinuesTheClipsOwnPast) {
  const TrainingClip clip = Walker(60);
  for (const bool mirrored : {false, true}) {
    const std::vector<float> whole = Window(clip, 0, 60, mirrored, false);
    const std::vector<float> part = Window(clip, 20, 25, mirrored, false);
    for (std::size_t i = 0; i < part.size(); ++i) {
      ASSERT_NEAR(part[i], whole[20 * body::kFeatureCount + i], 2e-4) << i % body::kFeatureCount;
    }
  }
}

TEST(Dataset, ASessionStartHasNoVelocity) {
  const TrainingClip clip = Walker(60);
  const std::vector<float> started = Window(clip, 20, 3, false, true);
  const std::vector<float> continued = Window(clip, 20, 3, false, false);
  float speed = 0, continued_speed = 0;
  for (int i = body::kVelocityBegin; i < body::kHipsHeightIndex; ++i) {
    speed += std::abs(started[i]);
    continued_speed += std::abs(continued[i]);
  }
  EXPECT_EQ(speed, 0.0F);
  EXPECT_GT(continued_speed, 1.0F);  // the control: without the flag the past is there
}

TEST(Dataset, StatisticsStandardizeAndKeepTheirFloors) {
  std::vector<TrainingClip> clips{Walker(60), Walker(60, 1.0F)};
  const FeatureStatistics statistics = ComputeStatistics(clips, {});
  EXPECT_NEAR(statistics.mean[body::kHipsHeightIndex], body::kHumanoid[0].y_m, 0.03);
  for (int i = 0; i < body::kFeatureCount; ++i) EXPECT_GE(statistics.deviation[i], 0.01F);
  EXPECT_FLOAT_EQ(statistics.deviation[body::kPositionBegin], 0.01F);  // hips: always zero
  // Mirrored clips are in it too, so what points left and right cancels.
  EXPECT_NEAR(statistics.mean[body::kPositionBegin + 3 * body::kHead], 0.0F, 1e-4);
}

TEST(Dataset, ArchivesThatAreNotUnpackedAreNamed) {
  const auto folder = std::filesystem::temp_directory_path() / "styled_dataset_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "some.tar.xz") << "x";
  const Status status = CheckDataFolder(folder);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.message().find("tar -xJf"), std::string::npos);
  std::filesystem::remove_all(folder);
  EXPECT_FALSE(CheckDataFolder(folder).ok());
}

}  // namespace
}  // namespace styled::train
