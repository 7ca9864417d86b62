#include "model/stylist/domain.h"

#include <gtest/gtest.h>

namespace styled::stylist {
namespace {

constexpr float kStep_s = 1.0F / 120;

body::Quat Tilted(float rad) { return body::Quat(Eigen::AngleAxisf(rad, body::Vec3::UnitX())); }

struct DomainTest : testing::Test {
  Options options;
  Domain domain;

  void Feed(float reconstruction_rad, float tilt_rad, int frames) {
    for (int i = 0; i < frames; ++i) {
      domain.Follow(reconstruction_rad, Tilted(tilt_rad), kStep_s, !started, options);
      started = true;
    }
  }
  bool started = false;
};

TEST_F(DomainTest, AKnownUprightPoseHasAllOfTheStyle) {
  Feed(0.3F, 0.5F, 10);
  EXPECT_EQ(domain.weight(), 1.0F);
  EXPECT_FALSE(domain.reduces());
  EXPECT_FALSE(domain.outside());
}

TEST_F(DomainTest, ABadReconstructionFadesTheStyleOutOverTheTimeConstant) {
  Feed(0.3F, 0, 10);
  Feed(1.2F, 0, 1);
  EXPECT_GT(domain.weight(), 0.95F) << "not at once";
  EXPECT_LT(domain.weight(), 1.0F);
  EXPECT_TRUE(domain.reduces());
  Feed(1.2F, 0, 240);
  EXPECT_NEAR(domain.weight(), 0, 1e-3F);
  EXPECT_TRUE(domain.outside());
  Feed(0.3F, 0, 240);
  EXPECT_NEAR(domain.weight(), 1, 1e-3F) << "and in again";
}

TEST_F(DomainTest, TheFirstFrameIsJudgedAsItIs) {
  Feed(1.2F, 0, 1);
  EXPECT_EQ(domain.weight(), 0);
}

TEST_F(DomainTest, HipsFarOffUprightHaveNoneOfTheStyleSoon) {
  Feed(0.3F, 0, 10);
  Feed(0.3F, 1.1F, 1);
  EXPECT_GT(domain.weight(), 0.9F) << "legs in the style would jerk";
  Feed(0.3F, 1.1F, 60);
  EXPECT_NEAR(domain.weight(), 0.5F, 1e-3F) << "half way between begin and end";
  Feed(0.3F, 1.35F, 60);
  EXPECT_NEAR(domain.weight(), 0, 1e-3F);
  EXPECT_TRUE(domain.outside());
  Feed(0.3F, 0, 60);
  EXPECT_NEAR(domain.weight(), 1, 1e-3F);
}

TEST_F(DomainTest, ResetForgets) {
  Feed(1.2F, 1.4F, 100);
  domain.Reset();
  EXPECT_EQ(domain.weight(), 1);
  EXPECT_FALSE(domain.outside());
}

}  // namespace
}  // namespace styled::stylist
