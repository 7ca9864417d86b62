#pragma once

#include <string>
#include <vector>

#include "model/synthetic/script.h"
#include "tests/support/daemon.h"

// Weights that take examples, and examples.
namespace styled::support {

// Writes random weights of the causal network with the styles "neutral", "style1" ... "style3"
// (aliases "s1" ...). Returns `file`.
std::string CausalWeights(const std::string& file);
// The synthetic performer's walk, or another motion, as the text of a BVH file.
std::string WalkBvh(double rate_hz, double seconds);
// The walk of a skeleton whose arms hang in its zero pose.
std::string HangingWalkBvh(double rate_hz, double seconds);
std::string MotionBvh(synthetic::Motion motion, double rate_hz, double seconds);
// The names of the daemon's styles, as it lists them.
std::vector<std::string> StylesOf(const Daemon& daemon);

}  // namespace styled::support
