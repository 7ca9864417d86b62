#pragma once

#include <vector>

#include "model/net/stgcn/graph_conv.h"
#include "model/net/stgcn/network.h"
#include "model/net/stgcn/time_conv.h"

// The weights in memory, in the order and layout in which the kernels read them. Included only by
// load.cpp and network.cpp.
namespace styled::stgcn {

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

// An ST-ResBlk with pooling: from T frames of V nodes to T/2 of V'. The second convolution over
// time and the skip path are scaled by 1 / sqrt 2.
struct EncoderBlock {
  int in = 0, out = 0;  // channels
  Norm norm1, norm2;
  GraphConv graph1, graph2;
  TimeConv time1, time2;
  net::PackedColumns skip;
  // The mean over each cluster, for the skip path.
  std::vector<int> pool_begins;
  std::vector<net::RowMixture::Part> pool_parts;
};

// Scale and shift from a code: [1 + γ; β] = weight code + bias, 2 C numbers.
struct AdaIn {
  net::RowMajor weight;
  Eigen::VectorXf bias;
};

// An ST-AdaIN-ResBlk with unpooling: from T frames of V' nodes to 2T of V. Copies of a node stay
// one until the second graph convolution.
struct DecoderBlock {
  int in = 0, out = 0;
  AdaIn adain1, adain2;
  GraphConv graph1, graph2;
  TimeConv time1, time2;
  net::PackedColumns skip;
  std::vector<int> clusters;         // of each node of V, its node of V'
  std::vector<float> cluster_sizes;  // [V']
};

struct Dense {
  net::RowMajor weight;
  Eigen::VectorXf bias;
};

struct GeneratorWeights {
  Linear in, out;
  std::array<EncoderBlock, 2> encoder;
  std::array<DecoderBlock, 2> decoder;
};

struct StyleEncoderWeights {
  Linear in, conv;  // conv: [80 * 4w, 4w]
  std::array<EncoderBlock, 2> blocks;
  std::vector<Dense> heads;  // one per domain, and the free head last
};

struct MappingWeights {
  Dense noise, label, first, second, out;
};

struct Network::Weights {
  const net::RowKernels* kernels = &net::BestRowKernels();
  int width = 0;
  Features mean, deviation, inverse_deviation;
  GeneratorWeights generator;
  StyleEncoderWeights encoder;
  MappingWeights mapping;
  std::vector<Code> mean_codes;
};

}  // namespace styled::stgcn
