#include "model/train/judge/gait.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/judge/walk.h"

namespace styled::judge {
namespace {

TEST(Gait, IsThatOfAWalkOfKnownSteps) {
  for (const float yaw_rad : {0.0F, 1.0F, 3.1F}) {
    const Gait gait = MeasureGait(Walk(yaw_rad), kRate_hz);
    EXPECT_NEAR(gait.speed_cm_s.value(), 130, 1);
    EXPECT_NEAR(gait.cadence_per_min.value(), 108, 2);
    EXPECT_NEAR(gait.bob_cm.value(), 4, 0.1);
    EXPECT_NEAR(gait.lowest_knee_deg.value(), kKnee_rad * 180 / std::numbers::pi, 0.1);
    EXPECT_NEAR(gait.mean_knee_deg.value(), kKnee_rad * 180 / std::numbers::pi, 0.1);
    // Thigh and shank turn about the hip joint together.
    const double foot_m =
        0.42 * (std::sin(kSwing_rad) + std::sin(kSwing_rad + kKnee_rad) +  // one forward ...
                std::sin(kSwing_rad) + std::sin(kSwing_rad - kKnee_rad));  // ... one back
    EXPECT_NEAR(gait.step_cm.value(), 100 * foot_m, 1.5);
    EXPECT_NEAR(gait.arm_swing_cm.value(), 100 * 2 * 0.52 * std::sin(kArm_rad), 1.5);
  }
}

TEST(Gait, OfAStandingBodyHasNoSteps) {
  std::vector<body::Pose> poses(240);
  for (std::size_t i = 0; i < poses.size(); ++i) {  // trembling feet pass no other foot
    const float tremble = 0.01F * std::sin(static_cast<float>(i));
    poses[i].rotations[body::kLeftUpperLeg] = body::Exp(body::Vec3(tremble, 0, 0));
  }
  const Gait gait = MeasureGait(poses, kRate_hz);
  EXPECT_EQ(gait.cadence_per_min.count, 0);
  EXPECT_EQ(gait.step_cm.count, 0);
  EXPECT_EQ(gait.bob_cm.count, 0);
  EXPECT_EQ(gait.arm_swing_cm.count, 0);
  EXPECT_NEAR(gait.speed_cm_s.value(), 0, 1e-6);
  EXPECT_NEAR(gait.mean_knee_deg.value(), 0, 0.1);
}

TEST(Gait, OfNothingIsNotMeasured) {
  const Gait gait = MeasureGait({}, kRate_hz);
  for (const GaitColumn& column : kGaitColumns) {
    EXPECT_EQ((gait.*column.figure).count, 0) << column.key;
  }
}

TEST(Gait, ClipsCountOnceEach) {
  Gait sum;
  const std::vector<body::Pose> walk = Walk(0);
  sum.Add(MeasureGait(walk, kRate_hz));
  sum.Add(MeasureGait(std::span(walk).first(200), kRate_hz));
  sum.Add(MeasureGait(std::vector<body::Pose>(30), kRate_hz));  // no steps, no second
  EXPECT_EQ(sum.cadence_per_min.count, 2);
  EXPECT_EQ(sum.speed_cm_s.count, 2);
  EXPECT_EQ(sum.mean_knee_deg.count, 3);
}

}  // namespace
}  // namespace styled::judge
