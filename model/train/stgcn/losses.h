#pragma once

#include <torch/torch.h>

namespace styled::train::st_gcn {

// The norm over the 21 joints of a difference of windows [B, T, 21, 7], mean over samples, frames
// and channels: cycle and identity loss as the authors compute them.
torch::Tensor JointNorm(const torch::Tensor& difference);

// Mean of `value` [B] where `mask` [B] is 1; 0 if it is nowhere.
torch::Tensor MaskedMean(const torch::Tensor& value, const torch::Tensor& mask);

// Half the squared gradient of `logit` [B] by `input`, a mean over samples (R1, Mescheder et al.
// 2018). Differentiable. `input` [B, ...] requires a gradient.
torch::Tensor GradientPenalty(const torch::Tensor& logit, const torch::Tensor& input);

// Mean distance between the joints of two windows of positions [..., 21, 3], in their unit.
torch::Tensor MeanDistance(const torch::Tensor& a, const torch::Tensor& b);

}  // namespace styled::train::st_gcn
