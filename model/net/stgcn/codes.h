#pragma once

#include <cstdint>
#include <span>

#include "model/net/clip_stylizer.h"
#include "model/net/stgcn/network.h"

// Arithmetic of style codes: they may be averaged, mixed, weakened and extrapolated. Linear paths
// between codes give monotone changes of style (Park et al. 2021, section 4.4). Allocates; any
// thread. Pinned by tests/unit/net/stgcn/codes_test.cpp.
namespace styled::stgcn {

struct WeightedCode {
  Code code;
  float weight = 1;
};

// The weighted mean; weights are not negative, and their sum is above 0.
Code Mean(std::span<const WeightedCode> codes);

// The code of reference clips without a label: the weighted mean of the free head's codes. Each
// clip's heading begins with its first frame. None is empty.
struct Reference {
  std::span<const Features> clip;
  float weight = 1;
};
Code CodeOf(const Network& network, std::span<const Reference> references, Scratch& scratch);

// F(z, domain) for the noise that `seed` stands for: the same number gives the same noise in every
// domain and on every machine.
Noise NoiseOf(std::uint64_t seed);
Code NoiseCode(const Network& network, std::uint64_t seed, int domain);

// A variation of a domain: mean + amount (F - mean).
Code Varied(const Network& network, std::uint64_t seed, int domain, float amount);

// neutral + alpha (code - neutral): 0 is neutral, 1 the code, above 1 more than it.
Code AtStrength(const Network& network, const Code& code, float alpha);

// neutral + Σ weight (code - neutral). Weights that sum to 1 give the weighted mean.
Code Mixed(const Network& network, std::span<const WeightedCode> codes);

// The domain whose mean code is nearest, and its distance over the mean distance of all pairs of
// domains' mean codes. Within the training data the distance is about 1 or less.
net::NearestStyle Nearest(const Network& network, const Code& code);

}  // namespace styled::stgcn
