#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <memory>
#include <string>

#include "model/base/status.h"
#include "model/net/safetensors.h"
#include "model/net/stylizer.h"
#include "model/train/safetensors_write.h"
#include "model/train/stgcn/networks.h"
#include "model/train/stgcn/windows.h"

namespace styled::train::st_gcn {

// Copies a tensor of a file that the runtime could read, so that it exists and has the expected
// size; throws if it is not float32. CopyStatistics: `features.mean` and `features.deviation`.
void CopyFloats(const net::SafetensorsView& view, const std::string& name, const torch::Tensor& to);
void CopyStatistics(const net::SafetensorsView& view, Statistics& statistics);

// The generator of a weights file, on the CPU and without gradients, and the data to run it on
// clips. Errors name file, key or tensor: all that the runtime refuses, and files of other
// families.
struct LoadedGenerator {
  std::unique_ptr<Generator> generator;
  net::Model model;                     // styles: those of the codes
  stgcn::FeatureParameters parameters;  // with the hemisphere of `statistics`
  Statistics statistics;
  torch::Tensor codes;  // [n, code]: the mean code of each style
  NamedTensors space;   // style encoder and mapping network, as in the file
};
Result<LoadedGenerator> ReadGenerator(const std::filesystem::path& file);

}  // namespace styled::train::st_gcn
