#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/base/realtime.h"
#include "model/net/kernels/rows.h"
#include "model/net/weights_file.h"

// The two layers that depend on a stream's past: convolutions over time and normalizations
// (equations: FORMAT.md). A layer is immutable and shared by all threads; its state of a stream
// lies in that stream's memory, at places assigned when the layer is made. A layer of the decoder
// has room for kDecodings of them, the reconstruction first. The functions of a step allocate
// nothing. Pinned by tests/unit/net/stgcn_causal/step_test.cpp.
namespace styled::stgcn_causal {

inline constexpr int kDecodings = 2;  // the performer's own style and the requested one
inline constexpr int kTaps = 3;

// Places in a stream's memory, in floats.
class Layout {
 public:
  // At a 64-byte boundary.
  std::size_t Reserve(std::size_t floats) {
    const std::size_t place = size_;
    size_ += (floats + net::kRowPanel - 1) / net::kRowPanel * net::kRowPanel;
    return place;
  }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

// y_t = bias + W_0 v_(t-2d) + W_1 v_(t-d) + W_2 v_t, from C channels to C, for each node; before
// the first frame v counts as equal to it. The inputs v lie in a ring.
class PastConv {
 public:
  PastConv() = default;
  // `weight`: [C, 3 C], element (o, 3 i + k) of W_k; `bias`: [C]; both are multiplied by `scale`.
  // `spacing`: d, frames. `copies`: 1 or kDecodings.
  PastConv(const net::RowMajor& weight, const Eigen::VectorXf& bias, float scale, int spacing,
           int nodes, int copies, Layout& layout);

  // The place of v of `frame` (0, 1, ...), to be written before Run: [copies, nodes, C].
  STYLED_REALTIME float* Input(float* memory, std::uint64_t frame) const noexcept;
  // y: [copies, nodes, C], of the first `copies`. `add`, of the same shape, is added; it may be y.
  STYLED_REALTIME void Run(const net::RowKernels& kernels, float* memory, std::uint64_t frame,
                           int copies, const float* add, float* y) const noexcept;
  // Copies the second decoding's ring to the first's.
  STYLED_REALTIME void Follow(float* memory) const noexcept;

 private:
  int spacing_ = 0, nodes_ = 0, channels_ = 0, copies_ = 0;
  net::PackedColumns weight_;
  net::AlignedFloats bias_;
  std::size_t ring_ = 0;  // [2 d + 1, copies, nodes, C]
};

// The weight of the past in a frame's statistics.
struct Forgetting {
  float keep = 0;   // λ
  float count = 0;  // N_t
};

// x̂ = (x - m) / sqrt(variance + ε) by channel, m and variance over the nodes of this frame and,
// fading, of those before it. The sums are kept relative to the learned start of m, which does not
// affect the variance and reduces rounding errors.
class PastNorm {
 public:
  PastNorm() = default;
  // `start_mean`, `start_square`: [C]. `node_weights`: how often each node of the input counts.
  PastNorm(const net::RowMajor& start_mean, const net::RowMajor& start_square,
           std::vector<float> node_weights, int copies, Layout& layout);

  // The statistics of a stream without frames, which count as `start_frames`.
  STYLED_REALTIME void Start(float start_frames, float* memory) const noexcept;
  // Accumulates x, [nodes, C], and writes x̂'s scale and shift, C numbers each. `scratch`: 2 C
  // floats.
  STYLED_REALTIME void Advance(const net::RowKernels& kernels, const float* x, int copy,
                               const Forgetting& past, float* memory, float* scale, float* shift,
                               float* scratch) const noexcept;
  STYLED_REALTIME void Follow(float* memory) const noexcept;

 private:
  int channels_ = 0, copies_ = 0;
  std::vector<float> node_weights_;
  float share_ = 0;              // 1 / the sum of the weights
  net::AlignedFloats centre_;    // start_mean
  std::vector<float> variance_;  // start_square - start_mean²
  std::size_t sums_ = 0;         // [copies, 2, C]: of x - centre, of its square
};

}  // namespace styled::stgcn_causal
