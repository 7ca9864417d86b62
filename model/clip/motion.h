#pragma once

#include <memory>
#include <string>
#include <vector>

#include "model/clip/clip.h"
#include "model/rig/binding.h"

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
  // Which joints are the humanoid's, for a format of humanoids; null: it finds them.
  std::shared_ptr<const rig::Binding> binding;
};

}  // namespace styled::clip
