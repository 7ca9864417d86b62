#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <span>
#include <vector>

#include "model/net/stgcn/features.h"
#include "model/train/stgcn/learner.h"

// The training framework's networks of the family st-gcn beside ours: random weights that went
// through the trainer's writer, and features as its tensors.
namespace styled::parity {

// Networks with random weights, and the same in a weights file. Nothing is at its initial value:
// biases, scales and the heads' sizes are drawn, too.
struct StgcnPair {
  StgcnPair(int64_t domains, int64_t width, uint64_t seed, const std::filesystem::path& file,
            stgcn::Normalization normalization = stgcn::Normalization::kNeighbours);

  train::st_gcn::Shape shape;
  train::st_gcn::Networks networks;
  train::st_gcn::Graph graph;
  torch::Tensor mean, deviation;  // [21, 7]

  // [1, frames, 21, 7], standardized; a length that 4 does not divide is filled up with its last.
  torch::Tensor Standardized(std::span<const stgcn::Features> clip) const;
  // The generator's output in features' units: as many frames as `clip` has.
  std::vector<stgcn::Features> Generate(std::span<const stgcn::Features> clip,
                                        const torch::Tensor& code) const;
};

}  // namespace styled::parity
