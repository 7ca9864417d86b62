#include "model/base/smooth.h"

#include <gtest/gtest.h>

#include "model/base/critically_damped.h"

namespace styled {
namespace {

TEST(SmoothTest, ACriticallyDampedValueTakesItsFirstValueAtOnceAndThenHasNoCorner) {
  CriticallyDamped value;
  EXPECT_EQ(value.Follow(3, 0.01F, 0.05F), 3);
  constexpr float kDt = 0.001F;
  float before = 3, speed = 0, most = 0;
  for (int i = 0; i < 1000; ++i) {
    const float now = value.Follow(4, kDt, 0.05F);
    most = std::max(most, std::abs((now - before) / kDt - speed) / kDt);
    speed = (now - before) / kDt;
    before = now;
  }
  EXPECT_NEAR(before, 4, 1e-4F);
  EXPECT_LT(most, 1.05F / (0.05F * 0.05F)) << "the jump over tau squared bounds its acceleration";
}

TEST(SmoothTest, ACriticallyDampedValueDoesNotDependOnTheFrameRate) {
  CriticallyDamped coarse, fine;
  (void)coarse.Follow(0, 0, 0.05F);
  (void)fine.Follow(0, 0, 0.05F);
  (void)coarse.Follow(1, 0.1F, 0.05F);
  for (int i = 0; i < 100; ++i) (void)fine.Follow(1, 0.001F, 0.05F);
  EXPECT_NEAR(coarse.value(), fine.value(), 1e-5F);
}

TEST(SmoothTest, TheSoftExcessIsZeroBelowAndHasNoCorner) {
  EXPECT_EQ(SoftExcess(-1, 0.1F), 0);
  EXPECT_EQ(SoftExcess(0, 0.1F), 0);
  EXPECT_FLOAT_EQ(SoftExcess(1, 0.1F), 0.9F);
  float slope = 0;
  for (float x = -0.1F; x < 0.4F; x += 1e-3F) {
    const float now = (SoftExcess(x + 1e-3F, 0.1F) - SoftExcess(x, 0.1F)) / 1e-3F;
    EXPECT_NEAR(now, slope, 6e-3F) << x;
    slope = now;
  }
}

}  // namespace
}  // namespace styled
