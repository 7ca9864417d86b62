#pragma once

#include <memory>

#include "model/net/stgcn_causal/network.h"
#include "tests/unit/net/stgcn/random_weights.h"

namespace styled::stgcn_causal {

using stgcn::Features;
using stgcn::WeightsFile;

// Well-formed random weights by `seed`, with the domains "neutral", "style1" (alias "s1"), ...
// Written from FORMAT.md, not from the loader.
WeightsFile RandomWeights(int domains, int width, unsigned seed);

// The network of those weights; aborts if they are refused.
std::shared_ptr<const Network> CausalNetwork(const WeightsFile& file);

}  // namespace styled::stgcn_causal
