#pragma once

#include <torch/torch.h>

namespace styled::judge {

// Internal, as classifier.h.

inline constexpr float kRotationNoise = 0.03F;  // deviation, on quaternions, during training

// Eq. 2 of Style-ERD, the squared half angle between rotations [N, 4J, T]: a mean over samples,
// joints and frames. Neither side has to be of length 1.
torch::Tensor QuaternionLoss(const torch::Tensor& expected, const torch::Tensor& found);

// The denoising auto-encoder over rotations, [N, 4J, T] with T a multiple of 4, whose encoder gives
// the features of FMD. Pinned by tests/unit/judge/auto_encoder_test.cpp.
struct AutoEncoderImpl : torch::nn::Module {
  AutoEncoderImpl();
  // Rotations less their mean [1, 4J, 1] to features [N, 512, T/4 - 5].
  torch::Tensor Encode(const torch::Tensor& centred) { return encoder->forward(centred); }
  // How far what is decoded from rotations with noise is from the rotations.
  torch::Tensor Loss(const torch::Tensor& rotations, const torch::Tensor& mean);

  torch::nn::Sequential encoder{nullptr}, decoder{nullptr};
};
TORCH_MODULE(AutoEncoder);

}  // namespace styled::judge
