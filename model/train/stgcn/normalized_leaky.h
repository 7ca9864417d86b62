#pragma once

#include <torch/torch.h>

namespace styled::train::st_gcn {

// Makes the means over frames and nodes of each sample and channel 0 and the deviations 1 (ε = 1e-5
// on the variance), then LeakyReLU(0.2) of scale · x + shift: [B, T, V, C], scale and shift [B, C]
// in float32. Moments and arithmetic are float32 whatever the type of x. Once differentiable. On
// the CPU forward and backward are three passes and two over the memory; composed of libtorch's
// operations they took a fifth of an iteration. Pinned by tests/unit/train/stgcn/layers_test.cpp.
torch::Tensor NormalizedLeaky(const torch::Tensor& x, const torch::Tensor& scale,
                              const torch::Tensor& shift);

// The same with libtorch's operations: for any device, and as the reference in tests.
torch::Tensor NormalizedLeakyByParts(const torch::Tensor& x, const torch::Tensor& scale,
                                     const torch::Tensor& shift);

}  // namespace styled::train::st_gcn
