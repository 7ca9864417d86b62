#include "model/train/stgcn_causal/past_norm.h"

#include "model/train/stgcn/layers.h"

namespace styled::train::st_gcn_causal {

using torch::Tensor;

Past::Past(int64_t frames, const torch::Device& device) {
  constexpr double kKeep = 1.0 - 1.0 / kMemory;
  const Tensor rows = torch::zeros({frames, frames}), first = torch::zeros({frames, 1});
  auto to = rows.accessor<float, 2>();
  auto start_to = first.accessor<float, 2>();
  double start = kStartFrames, count = kStartFrames;
  std::vector<double> weight;  // of the frames so far
  for (int64_t t = 0; t < frames; ++t) {
    for (double& one : weight) one *= kKeep;
    weight.push_back(1);
    start *= kKeep;
    count = kKeep * count + 1;
    for (int64_t u = 0; u <= t; ++u) {
      to[t][u] = static_cast<float>(weight[static_cast<std::size_t>(u)] / count);
    }
    start_to[t][0] = static_cast<float>(start / count);
  }
  shares = rows.to(device);
  this->start = first.to(device);
}

PastNorm::PastNorm(Parameters& parameters, const std::string& name, int64_t channels)
    : start_mean(parameters.Add(name + ".start_mean", {channels}, 0)),
      start_square(parameters.Add(name + ".start_square", {channels}, 0)) {
  const torch::NoGradGuard no_grad;
  start_square.fill_(1);
}

Tensor PastNorm::operator()(const Past& past, const Tensor& x, const Tensor& scale,
                            const Tensor& shift, const Tensor& share) const {
  const Tensor exact = x.to(torch::kFloat32), row = share.unsqueeze(0);
  // Means over nodes of x and of x²: [B, T, 2C].
  Tensor moments =
      torch::cat({st_gcn::Mix(row, exact), st_gcn::Mix(row, exact.square())}, 3).squeeze(2);
  if (observed_ != nullptr) {
    moments = moments.mean(1, true);
    observed_->sum += moments.flatten(0, 1).sum(0);
    observed_->windows += x.size(0);
    moments = moments.expand({-1, x.size(1), -1});
  } else {
    moments =
        at::matmul(past.shares, moments) + past.start * torch::cat({start_mean, start_square});
  }
  const std::vector<Tensor> parts = moments.chunk(2, 2);
  const Tensor variance = (parts[1] - parts[0].square()).clamp_min(0);
  const Tensor gain = (variance + kEpsilon).rsqrt() * scale.unsqueeze(1);
  const Tensor offset = shift.unsqueeze(1) - gain * parts[0];
  const Tensor y = torch::addcmul(offset.unsqueeze(2), exact, gain.unsqueeze(2));
  return at::leaky_relu(y, kSlope).to(x.scalar_type());
}

void PastNorm::Observe(bool on) {
  const torch::NoGradGuard no_grad;
  if (on) {
    observed_ = std::make_shared<Observed>();
    observed_->sum =
        torch::zeros({2 * start_mean.size(0)}, start_mean.options().requires_grad(false));
    return;
  }
  if (observed_ != nullptr && observed_->windows > 0) {
    const auto means = (observed_->sum / static_cast<double>(observed_->windows)).chunk(2);
    start_mean.copy_(means[0]);
    start_square.copy_(means[1]);
  }
  observed_.reset();
}

}  // namespace styled::train::st_gcn_causal
