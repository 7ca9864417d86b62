#pragma once

#include <torch/torch.h>

#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "model/clip/manifest.h"
#include "model/net/erd/features.h"
#include "model/train/erd/networks.h"

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

// Writes model/net/erd/FORMAT.md, version 2. `json` is ToJson's; also atomically.
Status WriteWeights(const Generator& generator, const torch::Tensor& mean,
                    const torch::Tensor& deviation, const std::string& json,
                    const std::filesystem::path& file);

// The shape that a ToJson string describes.
Result<GeneratorShape> ShapeFromJson(const std::string& json);

// What WriteWeights wrote, back in a generator on the CPU: shipped weights under the trainer's own
// code, for tests/parity. Errors name file and tensor.
struct LoadedWeights {
  std::unique_ptr<Generator> generator;
  torch::Tensor mean, deviation;
  erd::FeatureParameters features;  // rate, heading filter, hemisphere
  std::vector<std::string> styles;  // names; [0] is neutral
  std::string metadata;             // the JSON text
};
Result<LoadedWeights> ReadWeights(const std::filesystem::path& file);

// `base` with the styles of `few`, a network whose other parameters are base's: their branches and
// columns of the style inputs. `places`: where each of few's styles but neutral goes, one of base's
// own or behind them. The rest of base is copied bit for bit.
std::unique_ptr<Generator> WithStyles(const Generator& base, const Generator& few,
                                      const std::vector<int64_t>& places, const torch::Tensor& mean,
                                      const torch::Tensor& deviation);
// The metadata for it: `styles`, names and aliases, at `places`; `training` goes under "added" into
// how base was trained.
std::string WithStyles(const std::string& base, const std::vector<clip::ManifestStyle>& styles,
                       const std::vector<int64_t>& places, const std::string& training);

}  // namespace styled::train
