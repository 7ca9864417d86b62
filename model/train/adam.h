#pragma once

#include <torch/torch.h>

#include <string>
#include <utility>
#include <vector>

namespace styled::train {

// Named parameters that lie in one flat buffer, and their gradients in another: an Adam step, a
// running mean of the weights and a checkpoint are then a few operations on whole buffers.
class Parameters {
 public:
  // Registers a parameter drawn from U(-bound, bound).
  torch::Tensor Add(const std::string& name, torch::IntArrayRef shape, double bound);

  // Moves all into the flat buffers on `device`. Once, after the last Add. Handles returned by Add
  // stay valid.
  void Flatten(const torch::Device& device);

  torch::Tensor flat() const { return flat_; }
  torch::Tensor gradient() const { return gradient_; }
  const std::vector<std::pair<std::string, torch::Tensor>>& named() const { return named_; }
  torch::Tensor Find(const std::string& name) const;
  void ZeroGradient() { gradient_.zero_(); }
  // Whether backward passes compute gradients of these; true at first.
  void RequireGradient(bool required);

 private:
  std::vector<std::pair<std::string, torch::Tensor>> named_;
  torch::Tensor flat_, gradient_;
};

// Adam (Kingma & Ba 2015) over one flat buffer; its whole state is first, second and steps.
class Adam {
 public:
  explicit Adam(const Parameters& parameters, double beta1 = 0.9, double beta2 = 0.999);
  void Step(Parameters& parameters, double learning_rate);

  torch::Tensor first, second;
  int64_t steps = 0;

 private:
  double beta1_, beta2_;
};

}  // namespace styled::train
