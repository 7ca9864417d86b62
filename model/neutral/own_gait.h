#pragma once

#include <Eigen/Core>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/gait/curve.h"

namespace styled::neutral {

// One gait of a performer, learned while they walk or run: the Fourier series of their rotations
// about the means of a reference curve, by recursive least squares with a prior. The prior is the
// gait of many people, turned to this performer's carriage; it weighs as much as a second or two of
// the performer's own (tuning.h). Value type of fixed size, no allocation; one thread at a time.
class OwnGait {
 public:
  // Adds `seconds` of the gait at a phase: `vectors` is log(mean_j^-1 rotation_j) of each joint,
  // with the means of the reference curve.
  STYLED_REALTIME void Learn(const gait::Terms& terms, const gait::Vectors& vectors,
                             float seconds) noexcept;
  // Finds the series from what was learned and the prior.
  STYLED_REALTIME void Solve(const gait::Series& prior) noexcept;

  const gait::Series& series() const { return series_; }
  // Seconds that were learned, at most tuning::kRemembered_s.
  float seconds() const { return seconds_; }

  // Exchanges left and right of what was learned.
  STYLED_REALTIME void Mirror() noexcept;
  // Begins with a series that was learned earlier, as if from `seconds`.
  STYLED_REALTIME void Know(const gait::Series& series, float seconds) noexcept;
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;  // see model/base/checkpoint.h

 private:
  using Normal = Eigen::Matrix<float, gait::kTerms, gait::kTerms>;
  Normal normal_ = Normal::Zero();             // sum of terms terms^T, s
  gait::Series right_ = gait::Series::Zero();  // sum of vectors terms^T, s
  gait::Series series_ = gait::Series::Zero();
  float seconds_ = 0;
};

}  // namespace styled::neutral
