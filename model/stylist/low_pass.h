#pragma once

#include <Eigen/Core>

#include "model/base/realtime.h"
#include "model/body/humanoid.h"

namespace styled::stylist {

// A change of style: per joint the rotation vector (rad) that turns the input's local rotation into
// the styled one, from the right.
using StyleDelta = Eigen::Matrix<float, 3, body::kJointCount>;

// The low-pass on the change of style: a Butterworth filter of third order, exact at any spacing of
// frames. Of filters with the same delay it is the one that leaves what a body does (below 4 Hz)
// alone and takes most of what only jerks: a third of the white-noise jerk of two equal real poles.
// A step overshoots by 8 %. Fixed size, no allocation; one thread.
class LowPass {
 public:
  // Toward `target`, which held since the call before, `dt_s` ago. `delay_s`: of slow changes; 0
  // takes the target as it is, without a past.
  STYLED_REALTIME void Follow(const StyleDelta& target, double dt_s, float delay_s) noexcept;

  // Exactly zero once what is left is too small to see.
  STYLED_REALTIME void SettleAtZero() noexcept;

  const StyleDelta& value() const { return value_; }
  const StyleDelta& first() const { return first_; }  // less delayed, less smooth

 private:
  StyleDelta first_ = StyleDelta::Zero();  // after the real pole
  StyleDelta value_ = StyleDelta::Zero();  // after the complex pair
  StyleDelta rate_ = StyleDelta::Zero();   // of value_, 1/s
};

}  // namespace styled::stylist
