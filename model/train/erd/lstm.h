#pragma once

#include <torch/torch.h>

#include <utility>

namespace styled::train::style_erd {

// One LSTM layer of G independent networks over a whole window. Shapes: x [G, T, N, Z] (groups,
// frames, samples), input_weight and hidden_weight [G, 4Z, Z], bias [G, 4Z] (gate order i, f, g,
// o), h0 and c0 [G, N, Z]. Returns the outputs [G, T, N, Z] and the last cell state [G, N, Z].
//
// On the CPU, forward and backward are written out by hand (lstm.cpp): op by op, the 250 steps of a
// training iteration cost more in dispatch than in arithmetic. It has no double backward: the
// gradient penalty passes through the critic only. On a CUDA device, a cell is one kernel forward
// and one backward, with the same restriction. Elsewhere, op by op. All are compared in
// tests/unit/train/lstm_test.cpp, the device's where there is one.
std::pair<torch::Tensor, torch::Tensor> LstmLayer(const torch::Tensor& x,
                                                  const torch::Tensor& input_weight,
                                                  const torch::Tensor& hidden_weight,
                                                  const torch::Tensor& bias,
                                                  const torch::Tensor& h0, const torch::Tensor& c0);

// The same, always op by op.
std::pair<torch::Tensor, torch::Tensor> LstmLayerByOps(
    const torch::Tensor& x, const torch::Tensor& input_weight, const torch::Tensor& hidden_weight,
    const torch::Tensor& bias, const torch::Tensor& h0, const torch::Tensor& c0);

}  // namespace styled::train::style_erd
