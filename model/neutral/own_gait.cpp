#include "model/neutral/own_gait.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "model/neutral/tuning.h"

namespace styled::neutral {

void OwnGait::Learn(const gait::Terms& terms, const gait::Vectors& vectors,
                    float seconds) noexcept {
  // Beyond what is remembered, the new replaces as much of the old.
  const float sum_s = seconds_ + seconds;
  if (sum_s > tuning::kRemembered_s) {
    const float kept = tuning::kRemembered_s / sum_s;
    normal_ *= kept;
    right_ *= kept;
  }
  seconds_ = std::min(sum_s, tuning::kRemembered_s);
  const gait::Terms weighted = seconds * terms;
  normal_.noalias() += weighted * terms.transpose();
  right_.noalias() += vectors * weighted.transpose();
}

// (normal + prior) series^T = right^T + prior prior_series^T, the prior diagonal.
void OwnGait::Solve(const gait::Series& prior) noexcept {
  gait::Terms weights = gait::Terms::Constant(tuning::kPattern_s / 2);
  weights[0] = tuning::kPatternMean_s;
  Normal normal = normal_;
  normal.diagonal() += weights;
  const Eigen::LLT<Normal> factor(normal);
  const Eigen::Matrix<float, gait::kTerms, gait::kNumbers> right =
      (right_ + prior * weights.asDiagonal()).transpose();
  Eigen::Matrix<float, gait::kTerms, gait::kNumbers> solved = factor.solve(right);
  if (solved.allFinite()) series_ = solved.transpose();
}

// Terms are uncorrelated over whole strides: 1 has the square 1, the others 1/2.
void OwnGait::Know(const gait::Series& series, float seconds) noexcept {
  seconds_ = std::clamp(seconds, 0.0F, tuning::kRemembered_s);
  gait::Terms squares = gait::Terms::Constant(seconds_ / 2);
  squares[0] = seconds_;
  normal_ = squares.asDiagonal();
  right_ = series * squares.asDiagonal();
  series_ = series;
}

void OwnGait::Mirror() noexcept {
  const gait::Terms signs = gait::MirrorSigns();
  normal_ = (signs.asDiagonal() * normal_ * signs.asDiagonal()).eval();
  right_ = gait::Mirrored(right_);
  series_ = gait::Mirrored(series_);
}

void OwnGait::Carry(Checkpoint& c) noexcept {
  c(normal_, right_, series_, seconds_);
  if (!c.reads() || !c.ok()) return;
  if (!normal_.allFinite() || !right_.allFinite() || !series_.allFinite() ||
      !(seconds_ >= 0 && seconds_ <= tuning::kRemembered_s)) {
    c.Refuse();
  }
}

}  // namespace styled::neutral
