#include "model/gait/velocity.h"

#include <gtest/gtest.h>

#include <limits>

namespace styled::gait {
namespace {

using body::Vec3;

TEST(VelocityTest, KnowsAConstantVelocityFromTheSecondFrameOn) {
  Velocity velocity;
  velocity.Follow(Vec3(5, 1, 5), 0);
  EXPECT_FALSE(velocity.known());
  for (int i = 1; i < 100; ++i) {
    velocity.Follow(Vec3(5 + 0.02F * static_cast<float>(i), 1, 5), 1.0F / 60);
    EXPECT_TRUE(velocity.known());
    EXPECT_NEAR(velocity.mps().x(), 1.2F, 1e-3F);
  }
}

TEST(VelocityTest, IsHorizontal) {
  Velocity velocity;
  for (int i = 0; i < 10; ++i) velocity.Follow(Vec3(0, static_cast<float>(i), 0), 0.1F);
  EXPECT_EQ(velocity.mps(), Vec3::Zero());
}

TEST(VelocityTest, AJumpOfTheOriginOrAPlaceThatIsNoNumberIsIgnored) {
  for (const float jump_m : {100.0F, std::numeric_limits<float>::quiet_NaN()}) {
    Velocity velocity;
    for (int i = 0; i < 60; ++i) velocity.Follow(Vec3(0, 0, 0.02F * i), 1.0F / 60);
    velocity.Follow(Vec3(jump_m, 0, 1.2F), 1.0F / 60);
    for (int i = 61; i < 63; ++i) velocity.Follow(Vec3(0, 0, 0.02F * i), 1.0F / 60);
    EXPECT_NEAR(velocity.mps().x(), 0, 1e-3F);
    EXPECT_NEAR(velocity.mps().z(), 1.2F, 1e-3F);
  }
}

}  // namespace
}  // namespace styled::gait
