#pragma once

#include <cstdint>
#include <span>

#include "model/net/stgcn/code_space.h"

// Arithmetic of style codes: they may be averaged, mixed, weakened and extrapolated. Linear paths
// between codes give monotone changes of style (Park et al. 2021, section 4.4). Allocates; any
// thread. Pinned by tests/unit/net/stgcn/codes_test.cpp.
namespace styled::stgcn {

struct WeightedCode {
  Code code;
  float weight = 1;
};

// Returns the code itself if it is within the range that the network knows. A code whose distance
// (of Nearest) is above kFarthest is pulled straight toward the nearest mean until it has that
// distance. An example that is not human motion, or three times a variation, would otherwise tear
// the body apart. A person in the T-pose as the example: the walk jerks 1.8 times as much as the
// input, one of zeros 1.3 times; with the weights before, 16 and 26 times without the limit. Styles
// never seen lie at 0.5 to 0.9. A distance that is not finite comes from broken weights, which must
// remain visible: such a code is unchanged.
inline constexpr float kFarthest = 1.5F;
Code PulledIn(const CodeSpace& space, const Code& code);

// F(z, domain) for the noise generated from `seed`: the same number gives the same noise in every
// domain and on every machine.
Noise NoiseOf(std::uint64_t seed);
Code NoiseCode(const CodeSpace& space, std::uint64_t seed, int domain);

// A variation of a domain: mean + amount (F - mean).
Code Varied(const CodeSpace& space, std::uint64_t seed, int domain, float amount);

// neutral + alpha (code - neutral): 0 is neutral, 1 the code, above 1 more than it.
Code AtStrength(const CodeSpace& space, const Code& code, float alpha);

// neutral + Σ weight (code - neutral). Weights that sum to 1 give the weighted mean.
Code Mixed(const CodeSpace& space, std::span<const WeightedCode> codes);

// The domain whose mean code is nearest, and its distance over the mean distance of all pairs of
// domains' mean codes. Within the training data the distance is about 1 or less.
net::NearestStyle Nearest(const CodeSpace& space, const Code& code);

}  // namespace styled::stgcn
