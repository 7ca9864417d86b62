#pragma once

#include <array>

#include "proto/arkit/shapes.h"

namespace styled::rigs {

// The face of the built-in performer: it talks, blinks every four seconds, smiles now and then, and
// looks about. ARKit's 52 weights, 0 .. 1, by the time since the start.
std::array<float, arkit::kShapes> SyntheticFace(double time_s);

}  // namespace styled::rigs
