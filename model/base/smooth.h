#pragma once

#include <cmath>

namespace styled {

// Scalar functions without corners, and the share of a one-pole filter. Pure; any thread. Pinned by
// tests/unit/base/smooth_test.cpp.

// 3u^2 - 2u^3, u clamped to 0 .. 1: a fade whose speed is 0 at both ends.
constexpr float SmoothStep(float u) {
  u = u < 0 ? 0 : (u > 1 ? 1 : u);
  return u * u * (3 - 2 * u);
}

// The same between `low` (0) and `high` (1); low < high.
constexpr float SmoothStep(float x, float low, float high) {
  return SmoothStep((x - low) / (high - low));
}

// max(0, x) with a rounded corner: 0 below 0, x - width above 2 * width, a parabola between. Its
// slope is continuous, and what is not positive stays exactly 0.
constexpr float SoftExcess(float x, float width) {
  if (x <= 0) return 0;
  return x < 2 * width ? x * x / (4 * width) : x - width;
}

// max(0, x) as a hyperbola: half of `corner` at 0, never 0, smooth in every derivative.
inline float SoftPositive(float x, float corner) { return 0.5F * (x + std::hypot(x, corner)); }

// The share of the distance to its target that a one-pole filter covers in `dt_s`; 1 without a
// time constant.
inline float DecayShare(float dt_s, float tau_s) {
  return tau_s <= 0 ? 1.0F : 1.0F - std::exp(-dt_s / tau_s);
}

}  // namespace styled
