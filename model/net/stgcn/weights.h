#pragma once

#include <vector>

#include "model/net/stgcn/layer_reader.h"
#include "model/net/stgcn/layers.h"
#include "model/net/stgcn/network.h"
#include "model/net/stgcn/time_conv.h"

// The weights in memory, in the order and layout in which the kernels read them. Included only by
// load.cpp and network.cpp.
namespace styled::stgcn {

// An ST-ResBlk with pooling: from T frames of V nodes to T/2 of V'. The second convolution over
// time is scaled by 1 / sqrt 2, as the skip path is.
struct EncoderBlock : EncoderNodes {
  Norm norm1, norm2;
  TimeConv time1, time2;
};

// Scale and shift from a code: [1 + γ; β] = weight code + bias, 2 C numbers.
struct AdaIn {
  net::RowMajor weight;
  Eigen::VectorXf bias;
};

// An ST-AdaIN-ResBlk with unpooling: from T frames of V' nodes to 2T of V.
struct DecoderBlock : DecoderNodes {
  AdaIn adain1, adain2;
  TimeConv time1, time2;
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
  Standardization standard;
  GeneratorWeights generator;
  StyleEncoderWeights encoder;
  MappingWeights mapping;
  std::vector<Code> mean_codes;
};

}  // namespace styled::stgcn
