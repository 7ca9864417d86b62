#pragma once

#include <vector>

#include "model/net/kernels/rows.h"
#include "model/net/stgcn/graph_conv.h"

// The layers of the generator without their convolutions over time, in the order and layout in
// which the kernels read them. Networks of whole clips and of live streams (stgcn_causal) share
// them.
namespace styled::stgcn {

inline constexpr float kNormEpsilon = 1e-5F;      // in the variance of every normalization
inline constexpr float kPathShare = 0.70710678F;  // 1 / sqrt 2: of each path in a block's sum

// Rows times a matrix, plus a bias that may differ by node.
struct Linear {
  net::PackedColumns weight;
  net::AlignedFloats bias;  // [bias_rows, weight.columns()]
  int bias_rows = 1;
};

// Scale and shift of a normalization without a code; empty: none.
struct Norm {
  std::vector<float> scale, shift;
};

// Of an ST-ResBlk with pooling, from V nodes to V'. The skip path is scaled by 1 / sqrt 2.
struct EncoderNodes {
  int in = 0, out = 0;  // channels
  GraphConv graph1, graph2;
  net::PackedColumns skip;
  // The mean over each cluster, for the skip path.
  std::vector<int> pool_begins;
  std::vector<net::RowMixture::Part> pool_parts;
};

// Of an ST-AdaIN-ResBlk with unpooling, from V' nodes to V. Copies of a node stay a single one
// until the second graph convolution. The skip path is scaled by 1 / sqrt 2.
struct DecoderNodes {
  int in = 0, out = 0;
  GraphConv graph1, graph2;
  net::PackedColumns skip;
  std::vector<int> clusters;         // of each node of V, its node of V'
  std::vector<float> cluster_sizes;  // [V']
};

}  // namespace styled::stgcn
