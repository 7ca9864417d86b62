#pragma once

#include "model/net/kernels/rows.h"
#include "model/net/weights_file.h"

namespace styled::stgcn {

// Memory of one convolution over time; of one size for all clips.
struct TimeScratch {
  net::AlignedFloats turned, product;
};

// A convolution over three frames, with zeros outside the clip, from C channels to C:
//   y_t = bias + Σ_k W_k x_(t+k-1).
// Four frames at a time by Winograd's minimal filtering F(4, 3) (Lavin and Gray 2016): six products
// instead of twelve, exact except for rounding, which stays below 1e-5 of the result. Immutable;
// any thread, each with its own scratch.
class TimeConv {
 public:
  TimeConv() = default;
  // `weight`: [C, 3 C], element (o, 3 i + k) of W_k; `bias`: [C]; both are multiplied by `scale`.
  TimeConv(const net::RowMajor& weight, const Eigen::VectorXf& bias, float scale);

  // The buffer that Run reads: room for `frames` frames, with zeros outside of them. Returns the
  // first frame.
  float* Prepare(net::AlignedFloats& buffer, int frames, int nodes) const;

  // The skip path, which is added to the result: [frames, rows, C], for node v its row row_of[v];
  // without `row_of` there is a row for each node.
  struct Skip {
    const float* x = nullptr;  // nullptr: nothing is added
    int rows = 0;
    const int* row_of = nullptr;
  };

  // x: [frames, nodes, C], prepared; y: the same shape; may be the skip path's if that has a row
  // for each node.
  void Run(const net::RowKernels& kernels, const float* x, int frames, int nodes, const Skip& skip,
           float* y, TimeScratch& scratch) const;

  int channels() const { return channels_; }

 private:
  int channels_ = 0;
  net::PackedColumns weights_;  // of each product C columns
  net::AlignedFloats bias_;
};

}  // namespace styled::stgcn
