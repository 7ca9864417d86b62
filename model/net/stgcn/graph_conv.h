#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "model/base/realtime.h"
#include "model/net/kernels/rows.h"
#include "model/net/stgcn/graph.h"
#include "model/net/weights_file.h"

namespace styled::stgcn {

// A graph convolution with its pooling or unpooling over space folded in: from S nodes of Cin
// channels to R nodes of Cout,
//   y_i = constant_i + Σ_k Σ_j M_k[j, i] W_k x_j,
// where M_k is the adjacency A_k, A_k with pooling after it, or A_k with unpooling before it. Each
// label multiplies as few rows as possible, exactly: W_k either for each node that has a
// neighbour of the label (mixed before the product) or for each node that is one (mixed after).
// Of 3 V rows these are 3 V' where pooling follows, 22 of 30 on level 1 and 7 of 15 on level 2.
// Immutable; any thread, each with its own scratch memory.
class GraphConv {
 public:
  GraphConv() = default;
  // `mixing`: M_k, [S, R]; `weight`: [kLabelCount Cout, Cin], the blocks W_k; `bias`:
  // [kLabelCount Cout]; `node_bias`: [R, Cout], added to the result. Channels are multiples of
  // net::kRowPanel.
  GraphConv(const std::array<Eigen::MatrixXf, kLabelCount>& mixing, const net::RowMajor& weight,
            const Eigen::VectorXf& bias, const net::RowMajor& node_bias);

  // Floats of scratch memory that Run needs.
  std::size_t ScratchSize(int frames) const;
  // x: [frames, S, Cin]; y: [frames, R, Cout], or its relu. Noexcept, no allocation.
  STYLED_REALTIME void Run(const net::RowKernels& kernels, const float* x, int frames, bool relu,
                           float* y, float* scratch) const noexcept;

  int in_nodes() const { return in_nodes_; }
  int out_nodes() const { return out_nodes_; }
  int in_channels() const { return in_channels_; }
  int out_channels() const { return out_channels_; }

 private:
  // A sparse product over nodes, as net::RowMixture reads it.
  struct Sparse {
    std::vector<int> begins{0};
    std::vector<net::RowMixture::Part> parts;
    int rows() const { return static_cast<int>(begins.size()) - 1; }
    void EndRow() { begins.push_back(static_cast<int>(parts.size())); }
  };
  struct OneLabel {
    bool is_mixed = false;  // before the product, else after it
    Sparse before;          // rows that W_k is applied to, from x; no rows: all of x as it is
    int rows = 0;           // of the product, per frame
    net::PackedColumns weight;
  };

  void PackLabel(const Eigen::MatrixXf& mixing, const Eigen::Ref<const net::RowMajor>& weight,
                 OneLabel& label);
  void LinkOutput(const std::array<Eigen::MatrixXf, kLabelCount>& mixing);
  STYLED_REALTIME void RunTogether(const net::RowKernels& kernels, const float* x, int frames,
                                   bool relu, float* y, float* scratch) const noexcept;

  int in_nodes_ = 0, out_nodes_ = 0, in_channels_ = 0, out_channels_ = 0;
  std::array<OneLabel, kLabelCount> labels_;
  Sparse after_;                 // from the labels' products to y
  bool together_ = false;        // every label is mixed before: one product of three terms
  net::PackedColumns all_;       // its weights
  net::AlignedFloats constant_;  // [R, Cout]
};

}  // namespace styled::stgcn
