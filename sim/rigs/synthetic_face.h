#pragma once

#include <array>

#include "proto/arkit/shapes.h"

namespace styled::rigs {

// The face of the built-in performer: it talks, blinks every four seconds, smiles now and then, and
// looks about. ARKit's 52 weights, 0 .. 1, by the time since the start.
std::array<float, arkit::kShapes> SyntheticFace(double time_s);

// Their head, turned against the gaze as that of a person who looks at the phone; rad.
struct SyntheticHead {
  float left_rad = 0, down_rad = 0, to_right_shoulder_rad = 0;
};
SyntheticHead HeadOfSyntheticFace(double time_s);

}  // namespace styled::rigs
