#include "model/net/erd/content.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace styled::erd {
namespace {

using net::kTogether;
using net::LstmOperands;
using net::Operands;

using Shares = PackedVector<net::kMaxContents>;

// P from the head's output, in place.
void Softmax(std::span<float> shares) noexcept {
  const float most = *std::max_element(shares.begin(), shares.end());
  float sum = 0;
  for (float& share : shares) sum += share = std::exp(share - most);
  for (float& share : shares) share /= sum;
}

// 1 - exp(-t / content_rise_s): a frame or two do not tell a content.
float Certainty(float per_frame, int frames) noexcept {
  return -std::expm1(-per_frame * static_cast<float>(frames));
}

// h' = LSTM(relu-MLP(u)) and P's numerators, one call per layer for all jobs.
template <Shape kShape>
void RunRecognizer(const Kernels& kernels, const ContentWeights<kShape>& weights,
                   std::span<const ContentJob<kShape>> jobs, std::span<Shares> logits) noexcept {
  std::array<PackedVector<kShape.encoder>, kTogether> hidden;
  std::array<PackedVector<kShape.latent>, kTogether> z;
  std::array<Operands, kTogether> operands;
  std::array<LstmOperands, kTogether> states;
  const std::size_t count = jobs.size();
  const auto all = std::span<const Operands>(operands).first(count);
  for (std::size_t k = 0; k < count; ++k) {
    operands[k] = {weights.layer0.bias.data(), jobs[k].u, hidden[k].data()};
  }
  Apply(kernels, weights.layer0.weight, all, true);
  for (std::size_t k = 0; k < count; ++k) {
    operands[k] = {weights.layer1.bias.data(), hidden[k].data(), z[k].data()};
  }
  Apply(kernels, weights.layer1.weight, all, false);
  for (std::size_t k = 0; k < count; ++k) {
    RecognizerStateOf<kShape>& state = jobs[k].state->recognizer;
    states[k] = {z[k].data(), state.h.data(), state.c.data()};
    operands[k] = {weights.head.bias.data(), state.h.data(), logits[k].data()};
  }
  kernels.lstm(kShape.latent, weights.lstm.weight.data(), weights.lstm.bias.data(),
               std::span<const LstmOperands>(states).first(count));
  Apply(kernels, weights.head.weight, all, false, weights.count);
}

template <int Rows>
void AddTo(PackedVector<Rows>& y, float factor, const PackedVector<Rows>& x) noexcept {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

}  // namespace

template <Shape kShape>
void StartRecognizer(const ContentWeights<kShape>& weights,
                     RecognizerStateOf<kShape>& state) noexcept {
  std::copy_n(weights.lstm.h0.begin(), kShape.latent, state.h.data());
  std::copy_n(weights.lstm.c0.begin(), kShape.latent, state.c.data());
  state.frames = 0;
}

template <Shape kShape>
void Recognized(const Kernels& kernels, const ContentWeights<kShape>& weights,
                const RecognizerStateOf<kShape>& state, std::span<float> shares) noexcept {
  Shares logits;
  const Operands operands{weights.head.bias.data(), state.h.data(), logits.data()};
  Apply(kernels, weights.head.weight, std::span(&operands, 1), false, weights.count);
  const auto own = std::span(logits).first(static_cast<std::size_t>(weights.count));
  Softmax(own);
  std::copy_n(own.begin(), std::min(own.size(), shares.size()), shares.begin());
}

template <Shape kShape>
void AddContents(const Kernels& kernels, const ContentWeights<kShape>& weights,
                 std::span<const ContentJob<kShape>> jobs) noexcept {
  std::array<Shares, kTogether> logits;
  RunRecognizer(kernels, weights, jobs, std::span(logits).first(jobs.size()));
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    const ContentJob<kShape>& job = jobs[k];
    RecognizerStateOf<kShape>& state = job.state->recognizer;
    const bool known = job.content >= 0 && job.content < weights.count;
    const auto content = static_cast<std::size_t>(known ? job.content : 0);
    if (known && state.frames == 0) job.state->neutral = weights.starts[content];
    std::copy_n(job.bias, job.out->size(), job.out->begin());
    if (known) {
      AddTo(*job.out, 1, weights.columns[content]);
    } else if (job.content == net::kContentRecognized && state.frames > 0) {
      const auto shares = std::span(logits[k]).first(static_cast<std::size_t>(weights.count));
      Softmax(shares);
      const float certainty = Certainty(weights.per_frame, state.frames);
      for (std::size_t i = 0; i < shares.size(); ++i) {
        AddTo(*job.out, certainty * shares[i], weights.columns[i]);
      }
    }
    state.frames = std::min(state.frames + 1, RecognizerStateOf<kShape>::kMostFrames);
  }
}

template void AddContents<kPaper>(const Kernels&, const ContentWeights<kPaper>&,
                                  std::span<const ContentJob<kPaper>>) noexcept;
template void AddContents<kWide>(const Kernels&, const ContentWeights<kWide>&,
                                 std::span<const ContentJob<kWide>>) noexcept;
template void StartRecognizer<kPaper>(const ContentWeights<kPaper>&,
                                      RecognizerStateOf<kPaper>&) noexcept;
template void StartRecognizer<kWide>(const ContentWeights<kWide>&,
                                     RecognizerStateOf<kWide>&) noexcept;
template void Recognized<kPaper>(const Kernels&, const ContentWeights<kPaper>&,
                                 const RecognizerStateOf<kPaper>&, std::span<float>) noexcept;
template void Recognized<kWide>(const Kernels&, const ContentWeights<kWide>&,
                                const RecognizerStateOf<kWide>&, std::span<float>) noexcept;

}  // namespace styled::erd
