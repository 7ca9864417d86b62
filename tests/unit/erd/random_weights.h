#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/erd/network.h"
#include "model/erd/safetensors.h"

namespace styled::erd {

// A weights file in pieces, so that a test can break one of them.
struct WeightsFile {
  nlohmann::json metadata;  // the value of __metadata__.styled, before it becomes text
  std::vector<NamedTensor> tensors;

  NamedTensor& tensor(const std::string& name);  // aborts if there is none
  std::vector<std::byte> Bytes() const;
};

// Weights that are well-formed and random by `seed`, scaled as a framework initializes them, with
// styles "neutral", "style1" (alias "s1"), ... Written from FORMAT.md, not from the loader.
WeightsFile RandomWeights(int style_count, unsigned seed);

// The network of those weights; aborts if they are refused.
std::shared_ptr<const Network> RandomNetwork(int style_count, unsigned seed);

}  // namespace styled::erd
