#pragma once

#include <Eigen/Core>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/humanoid.h"

namespace styled::stylist {

// A style delta: per joint the rotation vector (rad) that changes the input's local rotation into
// the styled one, applied from the right. The column kRise is how far the style raises the hips:
// (0, m, 0). One matrix, so that both pass through the same filters and fades.
inline constexpr int kRise = body::kJointCount;
using StyleDelta = Eigen::Matrix<float, 3, kRise + 1>;

// The low-pass on the style delta: a third-order Butterworth filter, exact for any spacing of
// frames. Among filters of the same delay it leaves body motion (below 4 Hz) unchanged and removes
// most jerk: it passes a third of the white-noise jerk of two equal real poles. A step overshoots
// by 8 %. Fixed size, no allocation; one thread at a time. Pinned by
// tests/unit/stylist/low_pass_test.cpp.
class LowPass {
 public:
  // Moves toward `target`, which was constant since the call `dt_s` before. `delay_s`: the delay of
  // slow changes; 0 sets the output to the target and clears the past.
  STYLED_REALTIME void Follow(const StyleDelta& target, double dt_s, float delay_s) noexcept;

  // Sets the output to exactly zero once it is too small to see.
  STYLED_REALTIME void SettleAtZero() noexcept;

  const StyleDelta& value() const { return value_; }
  const StyleDelta& first() const { return first_; }  // less delayed, less smooth
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(first_, value_, rate_); }

 private:
  StyleDelta first_ = StyleDelta::Zero();  // output of the real pole
  StyleDelta value_ = StyleDelta::Zero();  // output of the complex pair
  StyleDelta rate_ = StyleDelta::Zero();   // of value_, 1/s
};

}  // namespace styled::stylist
