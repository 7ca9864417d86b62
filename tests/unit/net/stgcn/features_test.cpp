#include "model/net/stgcn/features.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/net/erd/features.h"
#include "tests/unit/body/random_pose.h"

namespace styled::stgcn {
namespace {

using body::Angle_rad;
using body::kHips;
using body::kJointCount;
using body::Moved;
using body::Pose;
using body::Quat;
using body::Random;
using body::Upright;
using body::Vec3;

constexpr float kPi = std::numbers::pi_v<float>;

float LargestDifference(const Features& a, const Features& b) {
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

// Of one pose in a new stream; its heading.
Features Of(const Pose& pose, const FeatureParameters& parameters = {}, float* heading = nullptr) {
  HeadingState state;
  Features features;
  const float found = ComputeFeatures(pose, parameters, state, features);
  if (heading != nullptr) *heading = found;
  return features;
}

TEST(StgcnFeatures, AtRestArePositionsAboveTheFloorAndIdentityRotations) {
  const Features features = Of(Pose());
  for (int joint = 0; joint < kJointCount; ++joint) {
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(features[kChannels * joint + kPositionChannels + i], i == 3 ? 1 : 0, 1e-6);
    }
  }
  EXPECT_NEAR(features[kChannels * kHips + 1], 0.98, 1e-6) << "true height";
  EXPECT_NEAR(features[kChannels * body::kLeftHand], 0.67, 1e-5);
  EXPECT_NEAR(features[kChannels * body::kLeftToes + 1], 0.02, 1e-5);
}

TEST(StgcnFeatures, DoNotSeeWhereTheBodyStandsNorWhereItFacesButItsHeight) {
  Random random(2);
  for (int round = 0; round < 50; ++round) {
    const Pose pose = Upright(random);
    const float yaw = random.Between(-kPi, kPi);
    const Vec3 shift(random.Between(-9, 9), 0, random.Between(-9, 9));
    const Features here = Of(pose);
    EXPECT_LT(LargestDifference(here, Of(Moved(pose, yaw, shift))), 2e-5);
    const Features up = Of(Moved(pose, yaw, shift + Vec3(0, 0.5F, 0)));
    for (int joint = 0; joint < kJointCount; ++joint) {
      EXPECT_NEAR(up[kChannels * joint + 1] - here[kChannels * joint + 1], 0.5, 2e-5);
    }
    EXPECT_EQ(here[kChannels * kHips], 0);
    EXPECT_EQ(here[kChannels * kHips + 2], 0);
  }
}

TEST(StgcnFeatures, HeadingIsThatOfTheRecurrentFamily) {
  Random random(5);
  FeatureParameters parameters;
  erd::FeatureParameters theirs;
  parameters.rate_hz = theirs.rate_hz = 60;
  HeadingState state;
  erd::FeatureState their_state;
  Features features;
  erd::Features their_features;
  for (int frame = 0; frame < 100; ++frame) {
    const Pose pose = Moved(Upright(random), 0.1F * static_cast<float>(frame), Vec3::Zero());
    EXPECT_EQ(ComputeFeatures(pose, parameters, state, features),
              erd::ComputeFeatures(pose, theirs, their_state, their_features));
  }
}

TEST(StgcnFeatures, RotationsLieOnTheHemisphereAskedForWhateverTheSignOfTheInput) {
  Random random(3);
  FeatureParameters parameters;
  for (Quat& q : parameters.hemisphere) q = random.Turn(kPi);
  for (int round = 0; round < 20; ++round) {
    Pose pose = random.AnyPose();
    const Features features = Of(pose, parameters);
    for (int joint = 0; joint < kJointCount; ++joint) {
      const Eigen::Map<const Eigen::Vector4f> q(&features[kChannels * joint + kPositionChannels]);
      EXPECT_GE(q.dot(parameters.hemisphere[joint].coeffs()), 0);
      EXPECT_NEAR(q.norm(), 1, 1e-5);
    }
    for (Quat& q : pose.rotations) q.coeffs() *= -1;
    EXPECT_LT(LargestDifference(features, Of(pose, parameters)), 1e-6);
  }
}

TEST(StgcnFeatures, ThePoseComesBack) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    const Pose pose = Moved(Upright(random), random.Between(-kPi, kPi), random.Vector(3));
    float heading = 0;
    Features features = Of(pose, {}, &heading);
    for (int joint = 0; joint < kJointCount; ++joint) {  // a network's are not of length 1
      for (int i = 0; i < 4; ++i) features[kChannels * joint + kPositionChannels + i] *= 1.3F;
    }
    Pose back;
    PoseOf(features, heading, back);
    EXPECT_FLOAT_EQ(back.hips_position_m.y(), pose.hips_position_m.y());
    for (int joint = 0; joint < kJointCount; ++joint) {
      EXPECT_LT(Angle_rad(back.rotations[joint], pose.rotations[joint]), 2e-5) << joint;
    }
  }
}

TEST(StgcnFeatures, ARotationWithoutLengthIsTheIdentity) {
  Features features = Of(Pose());
  for (int i = 0; i < 4; ++i) features[kChannels * body::kHead + kPositionChannels + i] = 0;
  Pose pose;
  PoseOf(features, 0, pose);
  for (const Quat& q : pose.rotations) EXPECT_LT(Angle_rad(q, Quat::Identity()), 1e-6);
}

TEST(StgcnFeatures, MirroringThePoseMirrorsTheFeatures) {
  Random random(9);
  FeatureParameters parameters;
  HeadingState state, mirrored_state;
  Features features, mirrored, expected;
  for (int frame = 0; frame < 50; ++frame) {
    Pose pose = Moved(Upright(random), 0.3F * static_cast<float>(frame), random.Vector(3));
    ComputeFeatures(pose, parameters, state, features);
    body::Mirror(pose, pose);
    ComputeFeatures(pose, parameters, mirrored_state, mirrored);
    MirrorFeatures(features, expected);
    EXPECT_LT(LargestDifference(mirrored, expected), 2e-6);
    MirrorFeatures(expected, expected);
    EXPECT_EQ(expected, features) << "twice is exact";
  }
}

TEST(StgcnFeatures, TheHemisphereIsTheDirectionOfTheMean) {
  Features mean{};
  for (int joint = 0; joint < kJointCount; ++joint) {
    mean[kChannels * joint + kPositionChannels + joint % 4] = -0.5F;
  }
  FeatureParameters parameters;
  SetHemisphere(mean, parameters);
  for (int joint = 0; joint < kJointCount; ++joint) {
    EXPECT_FLOAT_EQ(parameters.hemisphere[joint].coeffs()[joint % 4], -1);
  }
}

}  // namespace
}  // namespace styled::stgcn
