#include "model/train/adam.h"

#include <cmath>

namespace styled::train {

using torch::Tensor;

Tensor Parameters::Add(const std::string& name, torch::IntArrayRef shape, double bound) {
  Tensor tensor = torch::empty(shape).uniform_(-bound, bound).requires_grad_(true);
  named_.emplace_back(name, tensor);
  return tensor;
}

void Parameters::Flatten(const torch::Device& device) {
  int64_t size = 0;
  for (const auto& [name, tensor] : named_) size += tensor.numel();
  flat_ = torch::empty({size}, device);
  gradient_ = torch::zeros({size}, device);
  int64_t begin = 0;
  for (auto& [name, tensor] : named_) {
    const int64_t count = tensor.numel();
    const Tensor place = flat_.narrow(0, begin, count).view(tensor.sizes());
    place.copy_(tensor.detach());
    tensor.set_data(place);
    tensor.mutable_grad() = gradient_.narrow(0, begin, count).view(tensor.sizes());
    begin += count;
  }
}

Tensor Parameters::Find(const std::string& name) const {
  for (const auto& [key, tensor] : named_) {
    if (key == name) return tensor;
  }
  TORCH_CHECK(false, "no parameter ", name);
}

void Parameters::RequireGradient(bool required) {
  for (const auto& [name, tensor] : named_) tensor.requires_grad_(required);
}

Adam::Adam(const Parameters& parameters, double beta1, double beta2)
    : first(torch::zeros_like(parameters.flat())),
      second(torch::zeros_like(parameters.flat())),
      beta1_(beta1),
      beta2_(beta2) {}

void Adam::Step(Parameters& parameters, double learning_rate) {
  torch::NoGradGuard no_grad;
  ++steps;
  const Tensor gradient = parameters.gradient();
  first.mul_(beta1_).add_(gradient, 1.0 - beta1_);
  second.mul_(beta2_).addcmul_(gradient, gradient, 1.0 - beta2_);
  const double correction1 = 1.0 - std::pow(beta1_, static_cast<double>(steps));
  const double correction2 = 1.0 - std::pow(beta2_, static_cast<double>(steps));
  const Tensor denominator = (second / correction2).sqrt_().add_(1e-8);
  parameters.flat().addcdiv_(first, denominator, -learning_rate / correction1);
}

}  // namespace styled::train
