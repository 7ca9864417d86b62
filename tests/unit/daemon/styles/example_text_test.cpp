// The example that is kept beside a style.
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/styles/library.h"
#include "model/clip/clip.h"

namespace styled::pipeline {
namespace {

std::vector<body::Pose> Walk(int frames) {
  std::vector<body::Pose> poses(static_cast<std::size_t>(frames));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const float angle = std::sin(0.01F * static_cast<float>(i));
    poses[i].rotations[3] = body::Quat(Eigen::AngleAxisf(angle, body::Vec3::UnitX()));
    poses[i].hips_position_m.z() = 0.01F * static_cast<float>(i);
  }
  return poses;
}

TEST(ExampleText, AnExampleIsKeptAtItsRateWhereItFits) {
  EXPECT_EQ(ExampleText({}, 60, 1000), "");
  const auto clip = clip::ParseBvh(ExampleText(Walk(600), 60, std::size_t{1} << 20), "x");
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  EXPECT_EQ(clip.value().frames.size(), 600U);
  EXPECT_EQ(clip.value().rate_hz, 60);
}

TEST(ExampleText, AnExampleIsNotMuchLongerThanItsFile) {
  constexpr double kRate_hz = 60, kLength_s = 60;
  const std::vector<body::Pose> poses = Walk(static_cast<int>(kLength_s * kRate_hz) + 1);
  for (const std::size_t most : {64U << 10U, 100U << 10U, 500U << 10U, 1000U << 10U}) {
    const std::string text = ExampleText(poses, kRate_hz, most);
    EXPECT_LE(text.size(), most);
    EXPECT_GT(text.size(), most / 3) << "not less than it could be";
    const auto clip = clip::ParseBvh(text, "x");
    ASSERT_TRUE(clip.ok()) << clip.status().message();
    const double length_s =
        static_cast<double>(clip.value().frames.size() - 1) / clip.value().rate_hz;
    EXPECT_NEAR(length_s, kLength_s, 1);
  }
}

}  // namespace
}  // namespace styled::pipeline
