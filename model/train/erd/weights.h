#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/net/erd/features.h"
#include "model/train/erd/networks.h"

namespace styled::train::style_erd {

// The content of a weights file besides its tensors.
struct WeightsMetadata {
  std::vector<std::pair<std::string, std::vector<std::string>>> styles;  // name, aliases
  double rate_hz = 30.0, heading_tau_s = 0.25;
  std::vector<std::string> contents;  // of the content input; empty: it has none
  double content_rise_s = 0;          // with contents
  std::string licence;
  std::string training = "{}";  // a JSON object: how the weights were made
  std::string ToJson(const GeneratorShape& shape) const;
};

// The shape that a ToJson text describes. Errors name what is missing.
Result<GeneratorShape> ShapeFromJson(const std::string& json);

// Writes model/net/erd/FORMAT.md, version 2. `mean` and `deviation` [211] are those of the
// features; `metadata` is ToJson's. Replaces `file` atomically; errors name it.
Status WriteWeights(const Generator& generator, const torch::Tensor& mean,
                    const torch::Tensor& deviation, const std::string& metadata,
                    const std::filesystem::path& file);

// A weights file in a generator on the CPU. Errors name file and tensor, including a tensor that is
// missing or has another shape. tests/parity runs shipped weights through this, the trainer's own
// code.
struct LoadedWeights {
  std::unique_ptr<Generator> generator;
  torch::Tensor mean, deviation;    // [211]
  erd::FeatureParameters features;  // rate, heading filter, hemisphere
  std::vector<std::string> styles;  // names; [0] is neutral
  std::string metadata;             // the JSON text
};
Result<LoadedWeights> ReadWeights(const std::filesystem::path& file);

}  // namespace styled::train::style_erd
