#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/status.h"
#include "model/net/licence.h"
#include "model/net/stylizer.h"

namespace styled::pipeline {

// The weights files that a configuration names: the main one, then the one for examples, if there
// is one. Errors list the places searched.
Result<std::vector<std::filesystem::path>> FindWeightsFiles(const config::Model& model);

// Their file names and hashes, as in recordings: "v2.safetensors+graph.safetensors". If the weights
// are rounded, both show it: "v2.safetensors in int8".
struct WeightsLabel {
  std::string names, hashes;
};
Result<WeightsLabel> LabelOf(const config::Model& model,
                             const std::vector<std::filesystem::path>& files);

// The networks of these files, combined into one (model/net/several).
struct Networks {
  std::shared_ptr<const net::Stylizer> network;
  int own_styles = 0;             // of the files
  std::string names;              // as in WeightsLabel
  std::vector<net::Terms> terms;  // of each file
  // CRC-32C of the tensors of the file whose network makes styles from examples. Such styles stay
  // valid when only the file's description of its styles changes.
  std::string examples_hash;
  std::uint32_t crc = 0;  // hash of all bytes and of the rounding
};

// Reads and tests them (model/trial). If running weights have the CRC-32C `running_crc` and these
// have it too, the test is skipped: `network` is null then, and the fields derived from it are not
// set. Blocks and allocates; start-up and reload only. Errors name the file.
Result<Networks> ReadNetworks(const config::Model& model, std::optional<std::uint32_t> running_crc);

}  // namespace styled::pipeline
