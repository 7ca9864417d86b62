#include "model/net/erd/features.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/body/random_pose.h"

namespace styled::erd {
namespace {

using body::kJointCount;
using body::kLeftHand;
using body::Moved;
using body::Pose;
using body::Quat;
using body::Random;
using body::Upright;
using body::Vec3;

constexpr float kPi = std::numbers::pi_v<float>;

float LargestDifference(const Features& a, const Features& b) {
  float largest = 0;
  for (int i = 0; i < kFeatureCount; ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(Features, AtRestAreIdentityRotationsRestPositionsAndNoSpeed) {
  FeatureState state;
  Features features;
  EXPECT_NEAR(ComputeFeatures(Pose(), {}, state, features), 0, 1e-6);
  for (int joint = 0; joint < kJointCount; ++joint) {
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(features[4 * joint + i], i == 3 ? 1 : 0, 1e-6);
  }
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(features[kPositionBegin + i], 0, 1e-6) << "hips origin";
  EXPECT_NEAR(features[kPositionBegin + 3 * kLeftHand], 0.67, 1e-5);
  for (int i = 0; i < kVelocityFeatures; ++i) EXPECT_EQ(features[kVelocityBegin + i], 0);
  EXPECT_NEAR(features[kHipsHeightIndex], 0.98, 1e-6);
}

TEST(Features, DoNotSeeWhereTheBodyStandsNorWhereItFaces) {
  Random random(2);
  for (int round = 0; round < 50; ++round) {
    const Pose first = Upright(random), second = Upright(random);
    const float yaw = random.Between(-kPi, kPi);
    const Vec3 shift(random.Between(-9, 9), 0, random.Between(-9, 9));
    FeatureState here, there;
    Features a, b;
    ComputeFeatures(first, {}, here, a);
    ComputeFeatures(Moved(first, yaw, shift), {}, there, b);
    EXPECT_LT(LargestDifference(a, b), 2e-5);
    ComputeFeatures(second, {}, here, a);
    ComputeFeatures(Moved(second, yaw, shift), {}, there, b);
    EXPECT_LT(LargestDifference(a, b), 2e-3) << "speeds: 30 times the rounding of positions";
  }
}

TEST(Features, SpeedIsTheStepTimesTheRateInTheHeadingFrame) {
  FeatureParameters parameters;
  parameters.rate_hz = 60;
  FeatureState state;
  Features features;
  const Pose start = Moved(Pose(), kPi / 2, Vec3::Zero());  // faces +X
  ComputeFeatures(start, parameters, state, features);
  ComputeFeatures(Moved(start, 0, Vec3(0.02F, 0, 0)), parameters, state, features);
  for (int joint = 0; joint < kJointCount; ++joint) {
    EXPECT_NEAR(features[kVelocityBegin + 3 * joint], 0, 1e-4);
    EXPECT_NEAR(features[kVelocityBegin + 3 * joint + 2], 1.2, 1e-4) << "forward, m/s";
  }
}

TEST(Features, HeadingIsFilteredWithItsTimeConstant) {
  FeatureParameters parameters;
  FeatureState state;
  Features features;
  ComputeFeatures(Pose(), parameters, state, features);
  const Pose turned = Moved(Pose(), 0.5F, Vec3::Zero());
  float heading = 0;
  for (int frame = 0; frame < 8; ++frame) {
    const float next = ComputeFeatures(turned, parameters, state, features);
    EXPECT_GT(next, heading) << "never backward";
    heading = next;
  }
  // 8 periods of 1/30 s against 0.25 s.
  EXPECT_NEAR(heading, 0.5 * (1 - std::exp(-8.0 / 30 / 0.25)), 0.01);

  parameters.heading_tau_s = 0;
  EXPECT_NEAR(ComputeFeatures(turned, parameters, state, features), 0.5, 1e-5);
}

TEST(Features, RotationsLieOnTheHemisphereAskedFor) {
  Random random(3);
  FeatureParameters parameters;
  for (Quat& q : parameters.hemisphere) q = random.Turn(kPi);
  for (int round = 0; round < 20; ++round) {
    FeatureState state;
    Features features;
    ComputeFeatures(random.AnyPose(), parameters, state, features);
    for (int joint = 0; joint < kJointCount; ++joint) {
      const Eigen::Map<const Eigen::Vector4f> q(&features[4 * joint]);
      EXPECT_GE(q.dot(parameters.hemisphere[joint].coeffs()), 0);
      EXPECT_NEAR(q.norm(), 1, 1e-5);
    }
  }
}

TEST(Features, AreTheSameForBothSignsOfTheInput) {
  Random random(4);
  Pose pose = Upright(random);
  FeatureState first, second;
  Features a, b;
  ComputeFeatures(pose, {}, first, a);
  for (Quat& q : pose.rotations) q.coeffs() *= -1;
  ComputeFeatures(pose, {}, second, b);
  EXPECT_LT(LargestDifference(a, b), 1e-6);
}

}  // namespace
}  // namespace styled::erd
