#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "model/net/kernels/rows.h"
#include "model/net/stgcn/layer_reader.h"
#include "model/net/stgcn/layers.h"
#include "model/net/stgcn/network.h"
#include "model/net/stgcn/size.h"
#include "model/net/stgcn/time_conv.h"

// The blocks of the networks of whole clips (equations: FORMAT.md), as generator and style encoder
// have them. A block is immutable; its intermediate results are in a thread's scratch. Included
// only by sources of this folder. Pinned by tests/unit/net/stgcn/network_test.cpp.
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

  Eigen::VectorXf Apply(const Eigen::VectorXf& x) const { return weight * x + bias; }
};

Dense ReadDense(net::TensorReader& tensors, const std::string& name, int rows, int columns);
// From `level` to the coarser one.
EncoderBlock ReadEncoder(LayerReader& layers, const std::string& name, int level, int in, int out,
                         bool normalized);
// From the coarser level to `level`.
DecoderBlock ReadDecoder(LayerReader& layers, const std::string& name, int level, int in, int out);

// The standardized features of `clip`, filled up with its last frame to `frames`, through the input
// layer. Returns [frames, 21, width], in the scratch.
const float* RunInput(const net::RowKernels& kernels, const Linear& in,
                      const Standardization& standard, std::span<const Features> clip, int frames,
                      Scratch& s);
// x: [frames, V, in]; y: [frames / 2, V', out].
void RunEncoder(const net::RowKernels& kernels, const EncoderBlock& block, const float* x,
                int frames, float* y, Scratch& s);
// x: [frames, V', in]; y: [2 frames, V, out].
void RunDecoder(const net::RowKernels& kernels, const DecoderBlock& block, const Code& code,
                const float* x, int frames, float* y, Scratch& s);

// The buffer, as large as that at least.
inline float* Sized(net::AlignedFloats& buffer, std::size_t size) {
  buffer.Grow(size);
  return buffer.data();
}

}  // namespace styled::stgcn
