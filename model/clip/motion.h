#pragma once

#include <string>
#include <vector>

#include "model/clip/clip.h"

namespace styled::clip {

// A clip with the data that export formats need in addition.
struct Motion : Clip {
  std::string name = "motion";
  // World rotations of the pose that a mesh is bound in, one per joint; empty: all identity.
  std::vector<rig::Quat> rest;
  // The time of each frame in seconds, increasing; empty: frame i is at i / rate_hz.
  std::vector<double> times_s;
  float metres_per_unit = 1;  // > 0
  // The rotation from the skeleton's axes to +Y up, +Z forward (glTF's axes).
  rig::Quat canonical_from_source = rig::Quat::Identity();
};

}  // namespace styled::clip
