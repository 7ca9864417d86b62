#include "model/train/judge/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/judge/plain_frechet.h"

namespace styled::judge {
namespace {

Eigen::VectorXd Vector(std::initializer_list<double> values) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), out.data());
  return out;
}

Eigen::MatrixXd Gaussian(int rows, const Eigen::RowVectorXd& mean,
                         const Eigen::RowVectorXd& deviation, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd out(rows, mean.size());
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < mean.size(); ++j) {
      out(i, j) = mean[j] + deviation[j] * normal(random);
    }
  }
  return out;
}

// A body in the rest pose whose hips follow `path`, at `rate_hz`.
template <typename Path>
std::vector<body::Pose> MovingAlong(int frames, double rate_hz, const Path& path) {
  std::vector<body::Pose> poses(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    poses[i].hips_position_m += path(static_cast<float>(i / rate_hz));
  }
  return poses;
}

TEST(Expression, OfTheRealShiftIsOneAndOne) {
  const Eigen::VectorXd real = Vector({0.3, -0.4, 0});
  const Expression expression = MeasureExpression(real, real);
  EXPECT_NEAR(expression.fraction, 1, 1e-12);
  EXPECT_NEAR(expression.cosine, 1, 1e-12);
}

TEST(Expression, HalfTheShiftIsHalfAsStrongInTheSameDirection) {
  const Expression expression = MeasureExpression(Vector({1, 2}), Vector({2, 4}));
  EXPECT_NEAR(expression.fraction, 0.5, 1e-12);
  EXPECT_NEAR(expression.cosine, 1, 1e-12);
}

TEST(Expression, AShiftToTheSideExpressesNothingHoweverLarge) {
  const Expression expression = MeasureExpression(Vector({0, 9}), Vector({1, 0}));
  EXPECT_NEAR(expression.fraction, 0, 1e-12);
  EXPECT_NEAR(expression.cosine, 0, 1e-12);
}

TEST(Expression, TheOppositeShiftIsNegative) {
  const Expression expression = MeasureExpression(Vector({-1, 0}), Vector({1, 0}));
  EXPECT_NEAR(expression.fraction, -1, 1e-12);
  EXPECT_NEAR(expression.cosine, -1, 1e-12);
}

TEST(Expression, OfNothingIsZeroNotNan) {
  EXPECT_EQ(MeasureExpression(Vector({0, 0}), Vector({1, 0})).cosine, 0);
  EXPECT_EQ(MeasureExpression(Vector({1, 0}), Vector({0, 0})).fraction, 0);
}

TEST(FrechetDistance, OfASetToItselfIsZero) {
  const Eigen::MatrixXd a = Gaussian(500, Vector({1, 2, 3}), Vector({1, 2, 0.5}), 1);
  EXPECT_NEAR(FrechetDistance(a, a), 0, 1e-9);
}

TEST(FrechetDistance, OfKnownGaussiansIsTheClosedForm) {
  const Eigen::MatrixXd a = Gaussian(40000, Vector({0, 0}), Vector({1, 3}), 1);
  const Eigen::MatrixXd b = Gaussian(40000, Vector({2, 0}), Vector({2, 3}), 2);
  // |mean|^2 + sum of (deviation difference)^2 = 4 + 1
  EXPECT_NEAR(FrechetDistance(a, b), 5, 0.15);
  EXPECT_NEAR(FrechetDistance(a, b), FrechetDistance(b, a), 1e-6);
}

TEST(FrechetDistance, SeesACorrelationThatMeansAndDeviationsDoNot) {
  Eigen::MatrixXd a = Gaussian(5000, Vector({0, 0}), Vector({1, 1}), 1);
  Eigen::MatrixXd b = a;
  b.col(1) = b.col(0);
  EXPECT_GT(FrechetDistance(a, b), 0.5);
}

TEST(FrechetDistance, IsItsFormulaWithAnEigenDecompositionOfTheTest) {
  Eigen::MatrixXd mix(5, 5);
  for (int i = 0; i < 25; ++i) mix(i / 5, i % 5) = std::sin(1.0 + i * i);
  const Eigen::MatrixXd a =
      Gaussian(60, Vector({1, 0, 2, 0, 0}), Vector({1, 2, 0.5, 1, 3}), 4) * mix;
  const Eigen::MatrixXd b =
      Gaussian(40, Vector({0, 0, 1, 5, 0}), Vector({2, 1, 0.5, 1, 1}), 5) * mix.transpose();
  EXPECT_NEAR(FrechetDistance(a, b), PlainFrechet(a, b), 1e-8);
  EXPECT_GT(FrechetDistance(a, b), 1);
}

TEST(Pca, ItsAxesSpanTheDirectionsOfLargestVariance) {
  const Eigen::MatrixXd samples = Gaussian(12, Eigen::RowVectorXd::Constant(40, 3.0),
                                           Eigen::RowVectorXd::LinSpaced(40, 0.1, 2), 6);
  const Pca pca = FitPca(samples, 4);
  const Eigen::MatrixXd axes = PlainAxes(samples, 4);
  EXPECT_LT((pca.axes * pca.axes.transpose() - axes * axes.transpose()).norm(), 1e-8);
  EXPECT_LT((pca.mean - samples.colwise().sum() / 12).norm(), 1e-12);
}

TEST(Pca, FindsTheAxisOfLargestVariance) {
  const Eigen::MatrixXd samples = Gaussian(2000, Vector({5, 0, 0}), Vector({0.1, 4, 0.1}), 1);
  const Pca pca = FitPca(samples, 1);
  ASSERT_EQ(pca.axes.cols(), 1);
  EXPECT_GT(std::abs(pca.axes(1, 0)), 0.99);
  EXPECT_NEAR(pca.Project(samples).mean(), 0, 1e-9);
}

TEST(Pca, KeepsNoMoreDimensionsThanThereAre) {
  EXPECT_EQ(FitPca(Gaussian(50, Vector({0, 0}), Vector({1, 1}), 1), 32).axes.cols(), 2);
}

TEST(MeanJerk, OfACubicIsItsThirdDerivative) {
  const auto poses = MovingAlong(50, 30, [](float t) { return body::Vec3(0, t * t * t, 0); });
  EXPECT_NEAR(MeanJerk(poses, 30).value(), 6, 0.1);
}

TEST(MeanJerk, IgnoresTheHorizontalPathOfTheHips) {
  const auto poses =
      MovingAlong(50, 30, [](float t) { return body::Vec3(std::sin(9 * t), 0, 5 * t); });
  EXPECT_NEAR(MeanJerk(poses, 30).value(), 0, 0.1);
}

TEST(MeanJerk, NeedsFourFrames) {
  const auto poses = MovingAlong(3, 30, [](float t) { return body::Vec3(0, t, 0); });
  EXPECT_EQ(MeanJerk(poses, 30).count, 0);
}

TEST(MeanJerk, GrowsWithNoiseThatVelocityHardlyShows) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0, 0.001F);
  const auto smooth = MovingAlong(100, 120, [](float t) { return body::Vec3(0, std::sin(t), 0); });
  const auto noisy = MovingAlong(
      100, 120, [&](float t) { return body::Vec3(0, std::sin(t) + normal(random), 0); });
  EXPECT_GT(MeanJerk(noisy, 120).value(), 100 * MeanJerk(smooth, 120).value());
}

// Amplitudes of 1 cm, whose jerk is proportional to the amplitude; `start` times as much in the
// first quarter second.
std::vector<body::Pose> Swaying(float amplitude, float start) {
  return MovingAlong(240, 120, [=](float t) {
    return body::Vec3(0, 0.01F * amplitude * (t < 0.25F ? start : 1) * std::sin(20 * t), 0);
  });
}

TEST(JerkRatios, AreOfTheClipItsBeginningAndItsRest) {
  const auto input = Swaying(1, 1);
  const JerkRatios same = MeasureJerkRatios(input, input, 120, 7);
  EXPECT_NEAR(same.clip.value(), 1, 1e-6);
  const JerkRatios twice = MeasureJerkRatios(input, Swaying(2, 3), 120, 7);
  EXPECT_NEAR(twice.first_quarter_second.value(), 6, 0.3);
  EXPECT_NEAR(twice.after_first_second.value(), 2, 0.05);
  EXPECT_GT(twice.clip.value(), twice.after_first_second.value());
  EXPECT_EQ(twice.worst_clip, 7);
}
TEST(JerkRatios, TheLargestIsThatOfOneFrameWhichTheMeanHides) {
  const auto input = Swaying(1, 1);
  auto output = input;
  output[120].hips_position_m.y() += 0.01F;  // a snap
  const JerkRatios ratios = MeasureJerkRatios(input, output, 120, 0);
  EXPECT_NEAR(ratios.largest.value(), 3 * 0.01 * 120 * 120 * 120 / (0.01 * 20 * 20 * 20), 20);
  EXPECT_LT(ratios.clip.value(), ratios.largest.value() / 20);
  JerkRatios sum = MeasureJerkRatios(input, input, 120, 1);
  EXPECT_NEAR(sum.largest.value(), 1, 1e-6);
  sum.Add(ratios);
  EXPECT_NEAR(sum.largest.value(), (1 + ratios.largest.value()) / 2, 1e-6);
  EXPECT_EQ(sum.worst_largest, ratios.worst_largest);
}
TEST(JerkRatios, OfClipsAreAveragedNotPooled) {
  JerkRatios sum;
  sum.Add(MeasureJerkRatios(Swaying(100, 1), Swaying(100, 1), 120, 0));  // a run: ratio 1
  sum.Add(MeasureJerkRatios(Swaying(1, 1), Swaying(3, 1), 120, 1));      // a gesture: ratio 3
  EXPECT_NEAR(sum.clip.value(), 2, 0.05);
  EXPECT_NEAR(sum.worst, 3, 0.1);
  EXPECT_EQ(sum.worst_clip, 1);
}
TEST(JerkRatios, OfAShortOrAStillInputAreNotMeasured) {
  const auto still = MovingAlong(240, 120, [](float) { return body::Vec3(0, 0, 0); });
  EXPECT_EQ(MeasureJerkRatios(still, Swaying(1, 1), 120, 0).clip.count, 0);
  const auto input = Swaying(1, 1);
  const JerkRatios beginning =
      MeasureJerkRatios(std::span(input).first(60), std::span(input).first(60), 120, 0);
  EXPECT_EQ(beginning.after_first_second.count, 0);
  EXPECT_EQ(beginning.first_quarter_second.count, 1);
}

TEST(LargestAccelerations, OfAParabolaIsTwice) {
  const auto poses = MovingAlong(20, 30, [](float t) { return body::Vec3(0, 0, t * t); });
  const std::vector<double> accelerations = LargestAccelerations(poses, 30);
  ASSERT_EQ(accelerations.size(), 18U);
  EXPECT_NEAR(accelerations[9], 2, 0.05);
}

TEST(Feet, ThatStandDoNotSkate) {
  const std::vector<body::Pose> still(60);
  const FeetFigures feet = MeasureFeet(still, still, 30);
  EXPECT_EQ(feet.skate_out_cm_s.count, 2 * 59);
  EXPECT_EQ(feet.skate_out_cm_s.value(), 0);
  EXPECT_EQ(feet.penetration_cm.value(), 0);
}

TEST(Feet, SlideAtTheSpeedOfTheOutputWhileTheInputStands) {
  const std::vector<body::Pose> still(60);
  const auto sliding =
      MovingAlong(60, 30, [](float t) { return body::Vec3(0.3F * t, 0, 0.4F * t); });
  const FeetFigures feet = MeasureFeet(still, sliding, 30);
  EXPECT_NEAR(feet.skate_out_cm_s.value(), 50, 0.1);
  EXPECT_EQ(feet.skate_in_cm_s.value(), 0);
}

TEST(Feet, InTheAirOrFastAreNotInContact) {
  const std::vector<body::Pose> still(60);
  const auto jump = MovingAlong(60, 30, [](float t) { return body::Vec3(0, t, 0); });
  EXPECT_LE(MeasureFeet(jump, still, 30).skate_in_cm_s.count, 2);
  const auto fast = MovingAlong(60, 30, [](float t) { return body::Vec3(0, 0, 2 * t); });
  EXPECT_EQ(MeasureFeet(fast, still, 30).skate_in_cm_s.count, 0);
}

TEST(Feet, BelowTheInputsFloorPenetrate) {
  const std::vector<body::Pose> still(10);
  const auto sunk = MovingAlong(10, 30, [](float) { return body::Vec3(0, -0.02F, 0); });
  const FeetFigures feet = MeasureFeet(still, sunk, 30);
  EXPECT_NEAR(feet.penetration_cm.value(), 2, 1e-3);
  EXPECT_NEAR(feet.deepest_cm, 2, 1e-3);
  EXPECT_EQ(MeasureFeet(sunk, still, 30).deepest_cm, 0);
}

TEST(MacroShare, GivesEveryCellTheSameSay) {
  const std::vector<ClipVerdict> verdicts = {
      {.cell = 0, .clip = 0, .hits = 90, .windows = 90},
      {.cell = 1, .clip = 1, .hits = 0, .windows = 10},
  };
  const Share share = MacroShare(verdicts, 1);
  EXPECT_NEAR(share.value, 0.5, 1e-12);
  EXPECT_EQ(share.worst, 0);
  EXPECT_EQ(share.worst_cell, 1);
  EXPECT_EQ(share.windows, 100);
}

TEST(MacroShare, IntervalHoldsTheValueAndShrinksWithMoreClips) {
  const auto width = [](int clips) {
    std::vector<ClipVerdict> verdicts;
    for (int i = 0; i < clips; ++i) {
      verdicts.push_back({.cell = 0, .clip = i, .hits = i % 2 ? 10.0 : 6.0, .windows = 10});
    }
    const Share share = MacroShare(verdicts, 1);
    EXPECT_LE(share.low, share.value);
    EXPECT_GE(share.high, share.value);
    return share.high - share.low;
  };
  EXPECT_GT(width(6), 2 * width(100));
}

TEST(MacroShare, OfNothingIsZeroWithoutAWorstCell) {
  const Share share = MacroShare({}, 1);
  EXPECT_EQ(share.value, 0);
  EXPECT_EQ(share.worst_cell, -1);
}

TEST(MacroShare, IsTheMeanOverJudgesAndKnowsTheirSpread) {
  ClipVerdict agreed{.cell = 0, .clip = 0};
  agreed.Add(std::vector<double>{4, 4}, 4);
  ClipVerdict disputed{.cell = 1, .clip = 1};
  disputed.Add(std::vector<double>{8, 0}, 10);
  const ClipVerdict unjudged{.cell = 2, .clip = 2};  // shorter than a window
  const std::vector<ClipVerdict> verdicts{unjudged, agreed, disputed};
  const Share share = MacroShare(verdicts, 1);
  EXPECT_NEAR(share.value, 0.7, 1e-12);
  ASSERT_EQ(share.by_judge.size(), 2U);
  EXPECT_NEAR(share.by_judge[0], 0.9, 1e-12);
  EXPECT_NEAR(share.by_judge[1], 0.5, 1e-12);
  EXPECT_NEAR(share.spread(), 0.4 / std::sqrt(2), 1e-12);
  EXPECT_LE(share.low, 0.4) << "the interval is of the mean over judges, over clips";
  EXPECT_GE(share.high, 1);
}

TEST(MacroShare, OfOneJudgeHasNoSpread) {
  ClipVerdict verdict{.cell = 0, .clip = 0};
  verdict.Add(std::vector<double>{3}, 4);
  EXPECT_TRUE(std::isnan(MacroShare(std::vector{verdict}, 1).spread()));
  EXPECT_TRUE(std::isnan(Spread({})));
}

TEST(Mean, AddsWhatEachJudgeSays) {
  Mean mean;
  mean.AddJudged(std::vector<double>{1, 3}, 4);
  Mean more;
  more.AddJudged(std::vector<double>{3, 5}, 4);
  mean.Add(more);
  EXPECT_NEAR(mean.value(), 0.75, 1e-12);
  EXPECT_NEAR(mean.spread(), 0.5 / std::sqrt(2), 1e-12);
  EXPECT_EQ(mean.once().count, 1);
  EXPECT_NEAR(mean.once().value(), mean.value(), 1e-12);
  EXPECT_NEAR(mean.once().spread(), mean.spread(), 1e-12);
  EXPECT_EQ(Mean().once().count, 0);
  EXPECT_TRUE(std::isnan(Mean().spread()));
}

TEST(Quantile, InterpolatesAndBearsAnEmptySet) {
  EXPECT_NEAR(Quantile({4, 1, 2, 3}, 0.5), 2.5, 1e-12);
  EXPECT_NEAR(Quantile({4, 1, 2, 3}, 1.0), 4, 1e-12);
  EXPECT_EQ(Quantile({}, 0.5), 0);
}

}  // namespace
}  // namespace styled::judge
