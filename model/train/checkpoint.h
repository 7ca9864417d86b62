#pragma once

#include <torch/torch.h>

#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/train/networks.h"

namespace styled::train {

// What a checkpoint holds: named tensors and strings.
struct Checkpoint {
  std::map<std::string, torch::Tensor> tensors;
  std::map<std::string, std::string> strings;
};

// What went wrong, in one line: libtorch's exceptions carry a whole stack.
std::string Reason(const std::exception& error);

// Written beside `file` and renamed, so that a reader (or a crash) never sees half of it.
Status WriteCheckpoint(const Checkpoint& checkpoint, const std::filesystem::path& file);
Status ReadCheckpoint(const std::filesystem::path& file, Checkpoint& checkpoint);

// What the weights file says besides its tensors.
struct WeightsMetadata {
  std::vector<std::pair<std::string, std::vector<std::string>>> styles;  // name, aliases
  double rate_hz = 30.0, heading_tau_s = 0.25;
  std::string licence;
  std::string training = "{}";  // JSON object
  std::string ToJson(const GeneratorShape& shape) const;
};

// Writes model/weights/FORMAT.md, version 1. `json` is ToJson's; also atomically.
Status WriteWeights(const Generator& generator, const torch::Tensor& mean,
                    const torch::Tensor& deviation, const std::string& json,
                    const std::filesystem::path& file);

// The shape that a ToJson string describes.
Result<GeneratorShape> ShapeFromJson(const std::string& json);

}  // namespace styled::train
