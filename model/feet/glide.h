#pragma once

#include <cmath>

#include "model/base/realtime.h"

namespace styled::feet {

// A critically damped second-order low-pass: what it follows may jump, its own velocity does not.
// The exact solution of x'' = (target - x) / tau^2 - 2 x' / tau over each step, so the frame rate
// does not matter. The first value is taken at once. Pinned by tests/unit/feet/smooth_test.cpp.
class Glide {
 public:
  STYLED_REALTIME float Follow(float target, float dt_s, float tau_s) noexcept {
    if (!started_ || tau_s <= 0) {
      started_ = true;
      value_ = target;
      velocity_ = 0;
      return value_;
    }
    const float decay = std::exp(-dt_s / tau_s);
    const float apart = value_ - target;
    const float slope = velocity_ + apart / tau_s;
    value_ = target + (apart + slope * dt_s) * decay;
    velocity_ = (velocity_ - slope * dt_s / tau_s) * decay;
    return value_;
  }
  // Begins at `value`, moving by `velocity` a second.
  STYLED_REALTIME void Start(float value, float velocity = 0) noexcept {
    value_ = value;
    velocity_ = velocity;
    started_ = true;
  }
  STYLED_REALTIME void Rest() noexcept { *this = Glide(); }
  float value() const { return value_; }

 private:
  float value_ = 0, velocity_ = 0;
  bool started_ = false;
};

// 3u^2 - 2u^3 between `low` (0) and `high` (1).
constexpr float SmoothStep(float x, float low, float high) {
  float u = (x - low) / (high - low);
  u = u < 0 ? 0 : (u > 1 ? 1 : u);
  return u * u * (3 - 2 * u);
}

// max(0, x) with a rounded corner: 0 below 0, x - width above 2 * width, a parabola between. Its
// slope is continuous, and what is not positive stays exactly 0.
constexpr float SoftExcess(float x, float width) {
  if (x <= 0) return 0;
  return x < 2 * width ? x * x / (4 * width) : x - width;
}

// The share of the way to its aim that a one-pole filter goes in dt.
inline float DecayShare(float dt_s, float tau_s) {
  return tau_s <= 0 ? 1.0F : 1.0F - std::exp(-dt_s / tau_s);
}

}  // namespace styled::feet
