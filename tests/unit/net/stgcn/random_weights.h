#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/net/safetensors.h"
#include "model/net/stgcn/network.h"

namespace styled::stgcn {

// A weights file in parts, so that a test can break one of them.
struct WeightsFile {
  nlohmann::json metadata;  // the value of __metadata__.styled, before it becomes text
  std::vector<net::NamedTensor> tensors;

  net::NamedTensor& tensor(const std::string& name);  // aborts if there is none
  const net::NamedTensor& tensor(const std::string& name) const;
  std::vector<std::byte> Bytes() const;
};

// Well-formed random weights by `seed`, scaled like a framework's initialization, with the domains
// "neutral", "style1" (alias "s1"), ... Written from FORMAT.md, not from the loader.
WeightsFile RandomWeights(int domains, int width, unsigned seed);

// The network of those weights; aborts if they are refused.
std::shared_ptr<const Network> NetworkOf(const WeightsFile& file);

// A synthetic performer's features at 30 Hz, who walks, runs and waves; with the heading in use.
std::vector<Features> WalkFeatures(int frames, const FeatureParameters& parameters);

}  // namespace styled::stgcn
