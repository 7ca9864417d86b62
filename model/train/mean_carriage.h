#pragma once

#include <Eigen/Core>
#include <array>

#include "model/neutral/carriage.h"

namespace styled::train {

// A weighted mean of rotations by joint, for such as are not far apart: their sum, each in the
// nearer sign. Pinned by the tests of reference.h and judge/visible.h.
class MeanCarriage {
 public:
  MeanCarriage() { sums_.fill(Eigen::Vector4d::Zero()); }
  void Add(int joint, const body::Quat& rotation, double weight = 1) {
    const auto j = static_cast<std::size_t>(joint);
    const Eigen::Vector4d value = rotation.coeffs().cast<double>();
    sums_[j] += value.dot(sums_[j]) < 0 ? Eigen::Vector4d(-weight * value) : weight * value;
    weights_[j] += weight;
  }
  bool any() const { return weights_[body::kHips] > 0; }
  // Of joints without a rotation, that of `otherwise`.
  neutral::Carriage Value(const neutral::Carriage& otherwise = {}) const {
    neutral::Carriage mean = otherwise;
    for (std::size_t j = 0; j < sums_.size(); ++j) {
      if (weights_[j] > 0) mean.rotations[j] = body::Quat(sums_[j].normalized().cast<float>());
    }
    return mean;
  }

 private:
  std::array<Eigen::Vector4d, body::kJointCount> sums_;
  std::array<double, body::kJointCount> weights_{};
};

}  // namespace styled::train
