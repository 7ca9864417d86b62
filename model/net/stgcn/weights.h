#pragma once

#include <memory>

#include "model/net/stgcn/blocks.h"
#include "model/net/stgcn/code_space.h"
#include "model/net/stgcn/layer_reader.h"
#include "model/net/stgcn/network.h"

// The weights in memory, in the order and layout in which the kernels read them. Included only by
// load.cpp and network.cpp.
namespace styled::stgcn {

struct GeneratorWeights {
  Linear in, out;
  std::array<EncoderBlock, 2> encoder;
  std::array<DecoderBlock, 2> decoder;
};

struct Network::Weights {
  const net::RowKernels* kernels = &net::BestRowKernels();
  int width = 0;
  Standardization standard;
  GeneratorWeights generator;
  std::unique_ptr<const CodeSpace> space;
};

}  // namespace styled::stgcn
