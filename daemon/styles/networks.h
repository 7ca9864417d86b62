#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/status.h"
#include "model/net/stylizer.h"

namespace styled::pipeline {

// The weights files that a configuration names: the main one, then that of examples, if there is
// one. Errors list the places searched.
Result<std::vector<std::filesystem::path>> FindWeightsFiles(const config::Model& model);

// Their file names and their hashes, as recordings name them: "v2.safetensors+graph.safetensors".
// Where weights are rounded, both say so: "v2.safetensors in bfloat16".
struct WeightsLabel {
  std::string names, hashes;
};
Result<WeightsLabel> LabelOf(const config::Model& model,
                             const std::vector<std::filesystem::path>& files);

// Their networks as one (model/net/several).
struct Networks {
  std::shared_ptr<const net::Stylizer> network;
  int own_styles = 0;  // of the files
  std::string names;   // as in WeightsLabel
  // CRC-32C of the tensors of the file whose network makes styles of examples: these stay what they
  // are where the file tells something else of its styles.
  std::string examples_hash;
  std::uint32_t crc = 0;  // of all bytes, and of what they are rounded to
};

// Reads and tries them (model/trial). Where weights run whose bytes have the CRC-32C `running_crc`
// and these have it too, nothing is tried again: `network` is null then, and what is known by it is
// not set. Blocks and allocates; start-up and reload only. Errors name the file.
Result<Networks> ReadNetworks(const config::Model& model, std::optional<std::uint32_t> running_crc);

}  // namespace styled::pipeline
