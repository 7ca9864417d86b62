#pragma once

#include <cmath>
#include <span>

#include "model/base/realtime.h"
#include "model/rig/skeleton.h"

namespace styled::source {

// Neither of zero length nor not finite.
STYLED_REALTIME inline bool IsRotation(const rig::Quat& q) noexcept {
  const float length2 = q.squaredNorm();
  return std::isfinite(length2) && length2 > 1e-6F;
}

// Computes the local rotations of `pose` from world rotations; parents must precede their children.
// A rotation of zero length, or one that is not finite, makes its joint and the children NaN; the
// stylist holds such joints.
STYLED_REALTIME inline void LocalFromWorld(std::span<const int> parents,
                                           std::span<const rig::Quat> world,
                                           rig::RigPose& pose) noexcept {
  for (std::size_t j = 0; j < parents.size(); ++j) {
    const rig::Quat here = world[j].normalized();
    pose.rotations[j] =
        parents[j] < 0
            ? here
            : world[static_cast<std::size_t>(parents[j])].normalized().conjugate() * here;
  }
}

// Computes the offsets from the parents, in the parents' frames, of a skeleton in the given world
// pose. `offsets` has a row per joint; the root's is its world position.
inline void OffsetsFromWorld(std::span<const int> parents, std::span<const rig::Vec3> positions,
                             std::span<const rig::Quat> rotations,
                             std::span<rig::Vec3> offsets) noexcept {
  for (std::size_t j = 0; j < parents.size(); ++j) {
    offsets[j] = positions[j];
    if (parents[j] < 0) continue;
    const auto parent = static_cast<std::size_t>(parents[j]);
    offsets[j] = rotations[parent].normalized().conjugate() * (positions[j] - positions[parent]);
  }
}

}  // namespace styled::source
