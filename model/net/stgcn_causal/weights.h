#pragma once

#include <array>
#include <memory>

#include "model/net/kernels/kernel.h"
#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn/graph.h"
#include "model/net/stgcn/layers.h"
#include "model/net/stgcn/network.h"
#include "model/net/stgcn_causal/network.h"
#include "model/net/stgcn_causal/past.h"
#include "model/net/stgcn_causal/points.h"
#include "model/net/stgcn_causal/variations.h"

// The weights in memory, in the order and layout in which the kernels read them. Included only by
// load.cpp and network.cpp.
namespace styled::stgcn_causal {

// An ST-ResBlk, from V nodes to V'. The second convolution over time is scaled by 1 / sqrt 2, as
// the skip path is.
struct EncoderBlock : stgcn::EncoderNodes {
  stgcn::Norm affine1, affine2;
  PastNorm norm1, norm2;
  PastConv time1, time2;
};

// An ST-AdaIN-ResBlk, from V' nodes to V. `adain1`, `adain2`: the positions of a style's scale and
// shift, [1 + γ; β], in its point (points.h).
struct DecoderBlock : stgcn::DecoderNodes {
  std::size_t adain1 = 0, adain2 = 0;
  PastNorm norm1, norm2;
  PastConv time1, time2;
};

// Places of a step's intermediate results in the stream's memory. With several decodings, the first
// dimension is theirs.
struct Scratch {
  std::size_t standardized;              // [21, 7]
  std::size_t points;                    // [kDecodings, PointSpace::size()]
  std::size_t in;                        // [21, w]
  std::array<std::size_t, 2> encoded;    // [10, 2w], [5, 4w]
  std::array<std::size_t, 2> decoded;    // [10, 2w], [21, w], each for all decodings
  std::size_t out;                       // [21, 7 padded]
  std::size_t affine, sums;              // scale and shift of a normalization
  std::size_t activated, between, skip;  // of the block that runs
  std::size_t graph;                     // of the graph convolution that runs
};

struct Network::Weights {
  const net::RowKernels* kernels = &net::BestRowKernels();
  const net::Kernels* vectors = &net::BestKernels();
  int width = 0;
  int memory = 0, start_frames = 0;  // M, K
  net::AlignedFloats mean, deviation, inverse_deviation;
  stgcn::Linear in, out;
  std::array<EncoderBlock, 2> encoder;
  std::array<DecoderBlock, 2> decoder;
  std::unique_ptr<const stgcn::CodeSpace> space;
  std::unique_ptr<const PointSpace> points;
  std::unique_ptr<const Variations> variations;
  Scratch scratch;
  std::size_t state_size = 0;  // floats of State::memory

  // Calls f with each normalization of the decoder and then each of its convolutions.
  template <typename F>
  void ForDecoder(F f) const {
    for (const DecoderBlock& block : decoder) {
      f(block.norm1);
      f(block.norm2);
      f(block.time1);
      f(block.time2);
    }
  }
};

}  // namespace styled::stgcn_causal
