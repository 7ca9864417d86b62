#include "model/train/judge/auto_encoder.h"

#include "model/net/erd/features.h"

namespace styled::judge {

AutoEncoderImpl::AutoEncoderImpl() {
  using namespace torch::nn;  // NOLINT
  const int c = erd::kRotationFeatures;
  encoder = register_module(
      "encoder", Sequential(Conv1d(Conv1dOptions(c, 128, 4).stride(4)), BatchNorm1d(128), ReLU(),
                            Conv1d(Conv1dOptions(128, 256, 3).dilation(2)), BatchNorm1d(256),
                            ReLU(), Conv1d(Conv1dOptions(256, 512, 2)), BatchNorm1d(512), ReLU()));
  decoder = register_module(
      "decoder",
      Sequential(ConvTranspose1d(ConvTranspose1dOptions(512, 256, 2)), BatchNorm1d(256), ReLU(),
                 ConvTranspose1d(ConvTranspose1dOptions(256, 128, 3).dilation(2)), BatchNorm1d(128),
                 ReLU(), ConvTranspose1d(ConvTranspose1dOptions(128, c, 4).stride(4))));
}

torch::Tensor AutoEncoderImpl::Loss(const torch::Tensor& rotations, const torch::Tensor& mean) {
  const torch::Tensor corrupt = rotations + kRotationNoise * torch::randn_like(rotations) - mean;
  return QuaternionLoss(rotations, decoder->forward(Encode(corrupt)) + mean);
}

torch::Tensor QuaternionLoss(const torch::Tensor& expected, const torch::Tensor& found) {
  const auto quaternions = [](const torch::Tensor& x) {  // [N, 4J, T] -> unit, [N, J, 4, T]
    const torch::Tensor q = x.view({x.size(0), body::kJointCount, 4, x.size(2)});
    return q / q.norm(2, {2}, true).clamp_min(1e-6);
  };
  const torch::Tensor dot = (quaternions(expected) * quaternions(found)).sum(2).abs();
  return dot.clamp_max(1 - 1e-6).acos().square().mean();
}

}  // namespace styled::judge
