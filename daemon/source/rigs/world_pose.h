#pragma once

#include <span>

#include "model/base/realtime.h"
#include "model/rig/skeleton.h"

namespace styled::source {

// Local rotations of `pose` from those in the world, parents before their children. Where one is of
// no length, or not finite, so is the joint's and its children's: the stylist holds them.
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

// Offsets from the parents, in the parents' frames, of a skeleton that stands like this. `offsets`
// has a row per joint; the root's is its place.
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
