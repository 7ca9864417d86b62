#include "model/train/stgcn/adam_with_decay.h"

#include <cmath>

namespace styled::train::st_gcn {
namespace {

constexpr float kEpsilon = 1e-8F;

struct Factors {
  float beta1, beta2, decay, step, second_correction;
};

void StepAll(int64_t count, const Factors& f, const float* __restrict gradient,
             float* __restrict weight, float* __restrict first, float* __restrict second) {
  for (int64_t i = 0; i < count; ++i) {
    const float g = gradient[i] + f.decay * weight[i];
    first[i] = f.beta1 * first[i] + (1 - f.beta1) * g;
    second[i] = f.beta2 * second[i] + (1 - f.beta2) * g * g;
    weight[i] -= f.step * first[i] / (std::sqrt(second[i] * f.second_correction) + kEpsilon);
  }
}

}  // namespace

void AdamWithDecay::Step(Parameters& parameters, double rate, double decay) {
  const torch::NoGradGuard no_grad;
  if (!parameters.flat().device().is_cpu()) {
    parameters.gradient().add_(parameters.flat(), decay);
    Adam::Step(parameters, rate);
    return;
  }
  ++steps;
  const double correction1 = 1 - std::pow(beta1_, static_cast<double>(steps));
  const double correction2 = 1 - std::pow(beta2_, static_cast<double>(steps));
  const Factors factors{.beta1 = static_cast<float>(beta1_),
                        .beta2 = static_cast<float>(beta2_),
                        .decay = static_cast<float>(decay),
                        .step = static_cast<float>(rate / correction1),
                        .second_correction = static_cast<float>(1 / correction2)};
  const torch::Tensor gradient = parameters.gradient(), flat = parameters.flat();
  StepAll(flat.numel(), factors, gradient.data_ptr<float>(), flat.data_ptr<float>(),
          first.data_ptr<float>(), second.data_ptr<float>());
}

}  // namespace styled::train::st_gcn
