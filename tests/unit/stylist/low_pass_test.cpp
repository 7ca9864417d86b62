#include "model/stylist/low_pass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace styled::stylist {
namespace {

constexpr double kPi = 3.14159265358979;

StyleDelta AllOf(float value) { return StyleDelta::Constant(value); }

// The amplitude of the output for a sine of amplitude 1, sampled densely, so that the sampling
// itself has no effect.
double Gain(double hz, float delay_s) {
  constexpr double kDt_s = 1e-4;
  LowPass filter;
  double most = 0;
  const int frames = static_cast<int>((1.0 + 3.0 / hz) / kDt_s);
  for (int i = 0; i < frames; ++i) {
    filter.Follow(AllOf(static_cast<float>(std::sin(2 * kPi * hz * i * kDt_s))), kDt_s, delay_s);
    if (i > frames / 2) most = std::max(most, std::abs(static_cast<double>(filter.value()(0, 0))));
  }
  return most;
}

TEST(LowPass, IsAButterworthFilterOfThirdOrder) {
  // |H| = 1 / sqrt(1 + (w / wc)^6), with wc = 2 / delay (Butterworth 1930).
  const double cutoff_hz = 2 / 0.05 / (2 * kPi);
  for (const double hz : {1.0, 3.0, cutoff_hz, 12.0, 25.0}) {
    EXPECT_NEAR(Gain(hz, 0.05F), 1 / std::sqrt(1 + std::pow(hz / cutoff_hz, 6)), 0.01) << hz;
  }
}

TEST(LowPass, ARampComesOutTheDelayLater) {
  LowPass filter;
  float out = 0;
  for (int i = 0; i <= 600; ++i) {
    filter.Follow(AllOf(static_cast<float>(i) / 600), 1.0 / 600, 0.05F);
    out = filter.value()(1, 7);
  }
  EXPECT_NEAR(1 - out, 0.05, 0.002);
}

TEST(LowPass, IsTheSameAtAnySpacingOfFrames) {
  LowPass coarse;
  LowPass fine;
  for (int frame = 0; frame < 20; ++frame) {
    const StyleDelta target = AllOf(frame % 5 < 2 ? 1.0F : -0.5F);
    coarse.Follow(target, 0.04, 0.05F);
    for (int i = 0; i < 40; ++i) fine.Follow(target, 0.001, 0.05F);
    EXPECT_NEAR(coarse.value()(2, 3), fine.value()(2, 3), 1e-4) << frame;
  }
}

TEST(LowPass, AStepArrivesAfterALittleOvershoot) {
  LowPass filter;
  float most = 0;
  for (int i = 0; i < 120; ++i) {
    filter.Follow(AllOf(1), 1.0 / 120, 0.05F);
    most = std::max(most, filter.value().maxCoeff());
  }
  EXPECT_GT(most, 1.05F);
  EXPECT_LT(most, 1.10F);
  EXPECT_NEAR(filter.value()(0, 0), 1, 1e-4);
}

TEST(LowPass, WithoutADelayNothingIsFiltered) {
  LowPass filter;
  filter.Follow(AllOf(1), 1.0 / 120, 0.05F);
  filter.Follow(AllOf(3), 1.0 / 120, 0);
  EXPECT_EQ(filter.value(), AllOf(3));
  EXPECT_EQ(filter.first(), AllOf(3));
}

TEST(LowPass, SettlesAtExactlyZero) {
  LowPass filter;
  filter.Follow(AllOf(1), 0, 0);
  filter.SettleAtZero();
  EXPECT_EQ(filter.value(), AllOf(1)) << "too early";
  int frames = 0;
  while (!filter.value().isZero(0) && frames < 240) {
    filter.Follow(AllOf(0), 1.0 / 120, 0.05F);
    filter.SettleAtZero();
    ++frames;
  }
  EXPECT_LT(frames, 120);
}

}  // namespace
}  // namespace styled::stylist
