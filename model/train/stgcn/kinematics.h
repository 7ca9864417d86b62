#pragma once

#include <torch/torch.h>

#include "model/train/stgcn/windows.h"

namespace styled::train::st_gcn {

// Differentiable kinematics of standardized windows [..., 21, 7], in float32. The rotations and the
// hips' height are published; positions follow from them, since the humanoid's bones have
// fixed lengths. The network also predicts positions, which agree with them only approximately.
class Kinematics {
 public:
  Kinematics(const Statistics& statistics, const torch::Device& device);

  // The window as published: rotations of length 1, positions that follow from them; standardized.
  torch::Tensor Published(const torch::Tensor& window) const;
  // The positions as stored in the window, m, [..., 21, 3].
  torch::Tensor Positions_m(const torch::Tensor& window) const;

  const torch::Tensor& mean() const { return mean_; }  // [21, 7]
  const torch::Tensor& deviation() const { return deviation_; }

 private:
  torch::Tensor mean_, deviation_;
  torch::Tensor parents_;    // [21]; the hips' is 0
  torch::Tensor offsets_m_;  // [21, 3]; the hips' is 0
  torch::Tensor ancestors_;  // [21, 21]: 1 where the column's joint moves the row's
  torch::Tensor vertical_;   // [3]: 0, 1, 0
};

}  // namespace styled::train::st_gcn
