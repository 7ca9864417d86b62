#include "model/net/stgcn_causal/past.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>

#include "model/net/stgcn/layers.h"
#include "model/net/stgcn/size.h"

namespace styled::stgcn_causal {

using stgcn::Size;

PastConv::PastConv(const net::RowMajor& weight, const Eigen::VectorXf& bias, float scale,
                   int spacing, int nodes, int copies, Layout& layout)
    : spacing_(spacing),
      nodes_(nodes),
      channels_(static_cast<int>(weight.rows())),
      copies_(copies),
      bias_(static_cast<std::size_t>(weight.rows())),
      ring_(layout.Reserve(Size(2 * spacing + 1, copies, nodes) * Size(channels_, 1))) {
  const std::array<int, kTaps> depths{channels_, channels_, channels_};
  weight_ = net::PackedColumns(depths, channels_);
  for (int out = 0; out < channels_; ++out) {
    for (int in = 0; in < channels_; ++in) {
      for (int tap = 0; tap < kTaps; ++tap) {
        weight_.At(static_cast<std::size_t>(tap), out, in) = scale * weight(out, kTaps * in + tap);
      }
    }
    bias_.data()[out] = scale * bias[out];
  }
}

float* PastConv::Input(float* memory, std::uint64_t frame) const noexcept {
  const std::uint64_t slot = frame % static_cast<std::uint64_t>(2 * spacing_ + 1);
  return memory + ring_ + slot * Size(copies_, nodes_, channels_);
}

void PastConv::Run(const net::RowKernels& kernels, float* memory, std::uint64_t frame, int copies,
                   const float* add, float* y) const noexcept {
  assert(copies >= 1 && copies <= copies_);
  const float* const now = Input(memory, frame);
  if (frame == 0) {
    for (int past = 1; past <= 2 * spacing_; ++past) {
      std::copy_n(now, Size(copies, nodes_, channels_),
                  Input(memory, static_cast<std::uint64_t>(past)));
    }
  }
  // In a ring of 2 d + 1 frames, d + 1 frames on is d frames ago, and one frame on is 2 d ago.
  const auto ahead = [&](int frames) {
    return Input(memory, frame + static_cast<std::uint64_t>(frames));
  };
  const std::array<net::RowTerm, kTaps> terms{
      {{ahead(1), channels_}, {ahead(spacing_ + 1), channels_}, {now, channels_}}};
  kernels.product({&weight_, terms, copies * nodes_, bias_.data(), 1, add, false, y, channels_});
}

void PastConv::Follow(float* memory) const noexcept {
  const std::size_t one = Size(nodes_, channels_);
  for (int slot = 0; slot <= 2 * spacing_; ++slot) {
    float* const first = Input(memory, static_cast<std::uint64_t>(slot));
    std::copy_n(first, one, first + one);
  }
}

PastNorm::PastNorm(const net::RowMajor& start_mean, const net::RowMajor& start_square,
                   std::vector<float> node_weights, int copies, Layout& layout)
    : channels_(static_cast<int>(start_mean.size())),
      copies_(copies),
      node_weights_(std::move(node_weights)),
      share_(1 / std::accumulate(node_weights_.begin(), node_weights_.end(), 0.0F)),
      centre_(static_cast<std::size_t>(start_mean.size())),
      sums_(layout.Reserve(Size(copies, 2, channels_))) {
  for (int c = 0; c < channels_; ++c) {
    const auto mean = static_cast<double>(start_mean(c, 0));
    centre_.data()[c] = start_mean(c, 0);
    variance_.push_back(static_cast<float>(static_cast<double>(start_square(c, 0)) - mean * mean));
  }
}

void PastNorm::Start(float start_frames, float* memory) const noexcept {
  float* sums = memory + sums_;
  for (int copy = 0; copy < copies_; ++copy) {
    std::fill_n(sums, channels_, 0.0F);
    sums += channels_;
    for (const float variance : variance_) *sums++ = start_frames * variance;
  }
}

void PastNorm::Advance(const net::RowKernels& kernels, const float* x, int copy,
                       const Forgetting& past, float* memory, float* scale, float* shift,
                       float* scratch) const noexcept {
  assert(copy < copies_);
  const int rows = static_cast<int>(node_weights_.size());
  float* const sum = memory + sums_ + Size(copy, 2, channels_);
  float* const squares = sum + channels_;
  const float* const of_x = scratch;
  const float* const of_square = scratch + channels_;
  const float* const centre = centre_.data();
  kernels.sum(x, rows, channels_, node_weights_.data(), rows, centre, 1, scratch);
  kernels.sum(x, rows, channels_, node_weights_.data(), rows, centre, 2, scratch + channels_);
  const float share = share_, keep = past.keep, per_count = 1 / past.count;
  for (int c = 0; c < channels_; ++c) {
    sum[c] = keep * sum[c] + share * of_x[c];
    squares[c] = keep * squares[c] + share * of_square[c];
    const float mean = per_count * sum[c];
    const float variance = std::max(per_count * squares[c] - mean * mean, 0.0F);
    scale[c] = 1 / std::sqrt(variance + stgcn::kNormEpsilon);
    shift[c] = -(centre[c] + mean) * scale[c];
  }
}

void PastNorm::Follow(float* memory) const noexcept {
  const std::size_t one = Size(2, channels_);
  std::copy_n(memory + sums_, one, memory + sums_ + one);
}

}  // namespace styled::stgcn_causal
