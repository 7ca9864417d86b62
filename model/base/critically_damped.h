#pragma once

#include <cmath>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"

namespace styled {

// A critically damped second-order low-pass of one number: its target may jump, its own velocity
// does not. Each step is the exact solution of x'' = (target - x) / tau^2 - 2 x' / tau with the
// target held over the step, so the result does not depend on the frame rate. A ramp is followed
// with a delay of 2 tau. Value type, no allocation; one thread at a time. Pinned by
// tests/unit/base/smooth_test.cpp.
class CriticallyDamped {
 public:
  // Moves toward `target` over `dt_s` seconds (>= 0) and returns the new value. The first call
  // after construction or Reset, and any call with tau_s <= 0, takes the target at once.
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
  // Continues from `value` with `velocity`, per second.
  STYLED_REALTIME void Start(float value, float velocity = 0) noexcept {
    value_ = value;
    velocity_ = velocity;
    started_ = true;
  }
  STYLED_REALTIME void Reset() noexcept { *this = CriticallyDamped(); }
  float value() const { return value_; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(value_, velocity_, started_); }

 private:
  float value_ = 0, velocity_ = 0;
  bool started_ = false;
};

}  // namespace styled
