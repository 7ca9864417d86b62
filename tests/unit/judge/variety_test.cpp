#include "model/train/judge/variety.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/body/heading.h"

namespace styled::judge {
namespace {

// A clip whose first joint is at `value` plus the frame times `slope`, in cm along x; all others
// rest at the origin.
LocalClip Line(int frames, float value_cm, float slope_cm = 0) {
  LocalClip clip = LocalClip::Zero(3 * body::kJointCount, frames);
  for (int i = 0; i < frames; ++i)
    clip(0, i) = 0.01F * (value_cm + slope_cm * static_cast<float>(i));
  return clip;
}
constexpr double kJoints = body::kJointCount;

TEST(Variety, LocalPositionsDoNotDependOnPlaceOrHeading) {
  std::vector<body::Pose> poses(10);
  std::vector<body::Pose> moved(10);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].rotations[body::kLeftUpperArm] = body::Exp(body::Vec3(0, 0.1F * float(i), 0));
    moved[i] = poses[i];
    moved[i].rotations[body::kHips] = body::Yaw(2.5F);
    moved[i].hips_position_m += body::Vec3(3, 0, -1);
  }
  const LocalClip a = LocalPositions(poses, 30);
  EXPECT_NEAR(Distance_cm(a, LocalPositions(moved, 30)), 0, 1e-3);
  // The left hand is on the left, and the toes are ahead of the feet.
  EXPECT_GT(a(3 * body::kLeftUpperArm, 0), 0.1F);
  EXPECT_GT(a(3 * body::kLeftToes + 2, 0), 0.1F);
  EXPECT_NEAR(a(3 * body::kHips + 1, 0), 0.98F, 1e-6F);
  for (body::Pose& pose : moved) pose.hips_position_m.y() += 0.1F;
  EXPECT_NEAR(Distance_cm(a, LocalPositions(moved, 30)), 10, 1e-3) << "height counts";
}

TEST(Variety, PairwiseDistanceIsTheMeanOverPairs) {
  const std::vector<LocalClip> set{Line(5, 0), Line(5, 21), Line(5, 42)};
  EXPECT_NEAR(PairwiseDistance_cm(set).value(), (21 + 21 + 42) / 3.0 / kJoints, 1e-4);
  EXPECT_EQ(PairwiseDistance_cm(set).count, 3);
  EXPECT_EQ(PairwiseDistance_cm(std::span(set).first(1)).count, 0);
}

TEST(Variety, AShiftInTimeIsNoDifference) {
  const std::vector<LocalClip> set{Line(40, 0, 1), Line(40, 7, 1), Line(3, 0)};
  EXPECT_NEAR(ShiftedPairwiseDistance_cm(set, 10).value(), 0, 1e-4);
  EXPECT_EQ(ShiftedPairwiseDistance_cm(set, 10).count, 2) << "the short clip is left out";
  EXPECT_GT(PairwiseDistance_cm(std::span(set).first(2)).value(), 0.3);
  const std::vector<LocalClip> apart{Line(40, 0, 1), Line(40, 100, 1)};
  EXPECT_GT(ShiftedPairwiseDistance_cm(apart, 10).value(), 2) << "no shift is long enough";
}

TEST(Variety, FollowingIsTheShareOfTheDeviationThatArrives) {
  const Eigen::Vector3d x(1, 0, 0);
  const Eigen::Vector3d y(0, 2, 0);
  const std::vector<Deviation> half{{x, 0.5 * x}, {y, 0.5 * y}};
  EXPECT_NEAR(MeasureFollowing(half).slope, 0.5, 1e-9);
  EXPECT_NEAR(MeasureFollowing(half).cosine, 1, 1e-9);
  const std::vector<Deviation> aside{{x, y}, {y, x}};
  EXPECT_NEAR(MeasureFollowing(aside).slope, 0, 1e-9);
  EXPECT_NEAR(MeasureFollowing(aside).cosine, 0, 1e-9);
  const std::vector<Deviation> deaf{{x, 0 * x}, {y, 0 * y}};
  EXPECT_NEAR(MeasureFollowing(deaf).slope, 0, 1e-9);
  EXPECT_EQ(MeasureFollowing(deaf).examples, 2);
  EXPECT_TRUE(std::isnan(MeasureFollowing({}).slope));
}

TEST(Variety, HalvesOfOneExampleAreNearerThanAnother) {
  EXPECT_NEAR(HalvesRatio(Line(5, 0), Line(5, 1), Line(5, 4)), 0.25, 1e-5);
  EXPECT_NEAR(HalvesRatio(Line(5, 0), Line(5, 4), Line(5, 4)), 1, 1e-5);
  EXPECT_EQ(HalvesRatio(Line(5, 3), Line(5, 3), Line(5, 3)), 1) << "no example is told apart";
  EXPECT_TRUE(std::isnan(HalvesRatio(Line(5, 0), Line(5, 1), Line(5, 0))));
}

TEST(Variety, InterpolationIsPlacedBetweenItsEnds) {
  const std::vector<LocalClip> even{Line(5, 0), Line(5, 2), Line(5, 4), Line(5, 6), Line(5, 8)};
  const Interpolation straight = MeasureInterpolation(even);
  EXPECT_THAT(straight.places,
              testing::Pointwise(testing::DoubleNear(1e-5), {0.0, 0.25, 0.5, 0.75, 1.0}));
  EXPECT_TRUE(straight.monotone);
  EXPECT_NEAR(straight.largest_step, 1, 1e-5);
  const std::vector<LocalClip> back{Line(5, 0), Line(5, 6), Line(5, 2), Line(5, 8)};
  EXPECT_FALSE(MeasureInterpolation(back).monotone);
  const std::vector<LocalClip> jump{Line(5, 0), Line(5, 0), Line(5, 8), Line(5, 8)};
  EXPECT_TRUE(MeasureInterpolation(jump).monotone);
  EXPECT_NEAR(MeasureInterpolation(jump).largest_step, 3, 1e-5);
  const std::vector<LocalClip> none{Line(5, 0), Line(5, 1), Line(5, 0)};
  EXPECT_TRUE(std::isnan(MeasureInterpolation(none).places[1]));
  EXPECT_FALSE(MeasureInterpolation(none).monotone);
}

TEST(Variety, CodesAndRanks) {
  EXPECT_NEAR(CodeDistance(Eigen::Vector2f(1, 2), Eigen::Vector2f(0, 4)), 1.5, 1e-6);
  const std::vector<double> a{1, 2, 3, 4};
  EXPECT_NEAR(RankCorrelation(a, std::vector<double>{10, 20, 30, 1000}), 1, 1e-9);
  EXPECT_NEAR(RankCorrelation(a, std::vector<double>{4, 3, 2, 1}), -1, 1e-9);
  EXPECT_NEAR(RankCorrelation(std::vector<double>{1, 1, 2, 2}, std::vector<double>{1, 2, 1, 2}), 0,
              1e-9);
  EXPECT_TRUE(std::isnan(RankCorrelation(a, std::vector<double>{5, 5, 5, 5})));
}

}  // namespace
}  // namespace styled::judge
