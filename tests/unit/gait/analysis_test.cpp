#include "model/gait/analysis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/unit/body/random_pose.h"
#include "tests/unit/gait/performed.h"

namespace styled::gait {
namespace {

using Poses = std::vector<body::Pose>;

Analysis Of(const std::string& script, double seconds, double rate_hz = 60) {
  return Analyse(Perform(script, seconds, rate_hz), static_cast<float>(rate_hz));
}

// The mean angle between the curve and the frames from `from_s` on, degrees.
double Apart_deg(const Gait& gait, const Poses& poses, double from_s = 2) {
  Follower follower;
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Phase& phase = follower.Follow(poses[i], 1.0F / 60);
    if (static_cast<double>(i) < 60 * from_s) continue;
    body::WorldPose world;
    body::ForwardKinematics(poses[i], world);
    const Rotations expected = HeadingRelative(poses[i], body::Heading_rad(world));
    const Rotations at = gait.curve.At(TermsAt(phase.phase_rad));
    for (std::size_t j = 0; j < at.size(); ++j) {
      sum += body::Angle_rad(at[j], expected[j]);
      ++count;
    }
  }
  return sum / count / static_cast<double>(kDegree);
}

TEST(AnalysisTest, AWalkAndARunAreTheirCurves) {
  const Analysis walk = Of("walk:60", 10);
  ASSERT_TRUE(walk.walk);
  EXPECT_FALSE(walk.run);
  EXPECT_FALSE(walk.standing);
  EXPECT_FALSE(walk.is_pose());
  EXPECT_GT(walk.walk->explained, 0.9F);
  EXPECT_NEAR(walk.walk->rate_rad_s, 0.909F * tuning::kTurn_rad, 0.03F * tuning::kTurn_rad);
  EXPECT_NEAR(walk.walk->speed_mps, 1.24F, 0.1F);
  EXPECT_NEAR(walk.walk->strides, 9, 0.5F);
  EXPECT_LT(Apart_deg(*walk.walk, Perform("walk:60", 10)), 1.5);
  const Analysis run = Of("run:60", 10);
  ASSERT_TRUE(run.run);
  EXPECT_FALSE(run.walk);
  EXPECT_GT(run.run->explained, 0.9F);
  EXPECT_LT(Apart_deg(*run.run, Perform("run:60", 10)), 3);
}

TEST(AnalysisTest, AClipWithBothHasBothAndAStand) {
  const Analysis analysis = Of("stand:3,walk:8,run:8", 19);
  ASSERT_TRUE(analysis.walk && analysis.run && analysis.standing);
  const Analysis walk = Of("walk:60", 10), run = Of("run:60", 10), stand = Of("stand:60", 5);
  for (std::size_t j = 0; j < analysis.posture.size(); ++j) {
    EXPECT_LT(body::Angle_rad(analysis.walk->curve.mean[j], walk.walk->curve.mean[j]), 0.1);
    EXPECT_LT(body::Angle_rad(analysis.run->curve.mean[j], run.run->curve.mean[j]), 0.1);
    EXPECT_LT(body::Angle_rad((*analysis.standing)[j], (*stand.standing)[j]), 0.1);
  }
  EXPECT_GT(analysis.standing_s, 1.5F);
}

// The curve of a clip of 2 or 3 s from the middle of a walk is that of the whole walk.
TEST(AnalysisTest, TwoPassesMakeDoWithTwoSeconds) {
  const Poses walk = Perform("walk:60", 20);
  for (const std::size_t seconds : {2, 3}) {
    for (std::size_t from = 300; from < 360; from += 7) {
      const Poses clip(walk.begin() + static_cast<std::ptrdiff_t>(from),
                       walk.begin() + static_cast<std::ptrdiff_t>(from + 60 * seconds));
      const Analysis analysis = Analyse(clip, 60);
      ASSERT_TRUE(analysis.walk) << seconds << " s from " << from;
      EXPECT_GT(analysis.walk->explained, 0.8F) << seconds << " s from " << from;
      EXPECT_LT(Apart_deg(*analysis.walk, walk), 3) << seconds << " s from " << from;
    }
  }
}

TEST(AnalysisTest, LessThanOneAndAHalfStridesAreNoGait) {
  EXPECT_FALSE(Of("walk:60", 1.4).has_gait());
  EXPECT_TRUE(Of("walk:60", 2.5).has_gait());
}

TEST(AnalysisTest, DoesNotDependOnTheRateOfFrames) {
  const Analysis expected = Of("walk:60", 10, 120);
  for (const double rate_hz : {24.0, 30.0, 60.0, 240.0}) {
    const Analysis analysis = Of("walk:60", 10, rate_hz);
    ASSERT_TRUE(analysis.walk);
    for (float phase_rad = 0; phase_rad < 6; phase_rad += 0.5F) {
      const Rotations a = expected.walk->curve.At(TermsAt(phase_rad));
      const Rotations b = analysis.walk->curve.At(TermsAt(phase_rad));
      for (std::size_t j = 0; j < a.size(); ++j) {
        EXPECT_LT(body::Angle_rad(a[j], b[j]), 0.06) << rate_hz << " joint " << j;
      }
    }
  }
}

TEST(AnalysisTest, IsTheSameWhereverOneWalks) {
  const Poses poses = Perform("walk:60", 6);
  Poses moved;
  for (const body::Pose& pose : poses) moved.push_back(body::Moved(pose, 2, {7, 0, -3}));
  const Analysis here = Analyse(poses, 60), there = Analyse(moved, 60);
  EXPECT_LT((here.walk->curve.series - there.walk->curve.series).cwiseAbs().maxCoeff(), 1e-3F);
}

TEST(AnalysisTest, APoseIsAPosture) {
  body::Random random(4);
  for (const body::Pose& pose : {body::Pose(), body::Upright(random)}) {
    for (const std::size_t frames : {1, 60}) {
      const Analysis analysis = Analyse(Poses(frames, pose), 30);
      EXPECT_TRUE(analysis.is_pose());
      EXPECT_FALSE(analysis.has_gait());
      body::WorldPose world;
      body::ForwardKinematics(pose, world);
      const Rotations expected = HeadingRelative(pose, body::Heading_rad(world));
      for (std::size_t j = 0; j < expected.size(); ++j) {
        EXPECT_LT(body::Angle_rad(analysis.posture[j], expected[j]), 1e-3);
      }
    }
  }
}

TEST(AnalysisTest, AGestureIsNoGaitAndNoPose) {
  const Analysis analysis = Of("wave-both:60", 10);
  EXPECT_FALSE(analysis.has_gait());
  EXPECT_FALSE(analysis.is_pose());
  EXPECT_TRUE(analysis.standing);
}

TEST(AnalysisTest, AbsurdPosesGiveFiniteCurves) {
  body::Random random(6);
  Poses poses;
  for (int i = 0; i < 300; ++i) poses.push_back(random.AnyPose());
  const Analysis analysis = Analyse(poses, 30);
  EXPECT_TRUE(std::isfinite(analysis.spread_rad));
  for (const auto& gait : {analysis.walk, analysis.run}) {
    if (gait) EXPECT_TRUE(gait->curve.series.allFinite());
  }
}

}  // namespace
}  // namespace styled::gait
