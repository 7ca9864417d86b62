#pragma once

#include <cmath>

namespace styled {

// Smooth scalar functions, and the step of a one-pole low-pass. Pure; any thread. Pinned by
// tests/unit/base/smooth_test.cpp.

// 3u^2 - 2u^3 with u clamped to 0 .. 1: a fade whose slope is 0 at both ends.
constexpr float SmoothStep(float u) {
  u = u < 0 ? 0 : (u > 1 ? 1 : u);
  return u * u * (3 - 2 * u);
}

// The same fade with x from `low` (result 0) to `high` (result 1). Needs low < high.
constexpr float SmoothStep(float x, float low, float high) {
  return SmoothStep((x - low) / (high - low));
}

// max(0, x) with a rounded corner: 0 for x <= 0, x - width for x >= 2 * width, a parabola between.
// The slope is continuous, and the result is exactly 0 for every x <= 0.
constexpr float SoftExcess(float x, float width) {
  if (x <= 0) return 0;
  return x < 2 * width ? x * x / (4 * width) : x - width;
}

// max(0, x) as a hyperbola: never 0, half of `corner` at x = 0, smooth in every derivative.
inline float SoftPositive(float x, float corner) { return 0.5F * (x + std::hypot(x, corner)); }

// The fraction of the distance to its target that a one-pole low-pass covers in `dt_s`. It is 1 if
// tau_s <= 0 (no smoothing).
inline float DecayShare(float dt_s, float tau_s) {
  return tau_s <= 0 ? 1.0F : 1.0F - std::exp(-dt_s / tau_s);
}

}  // namespace styled
