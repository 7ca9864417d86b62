#pragma once

#include <string>
#include <vector>

#include "model/body/pose.h"

namespace styled::rig {

using body::Quat;
using body::Vec3;

// Any source skeleton, in its own units and axes. Parents precede their children; joint 0 is the
// only root (parent -1). All vectors have one entry per joint.
struct Skeleton {
  std::vector<std::string> names;
  std::vector<int> parents;
  std::vector<Vec3> offsets;  // from the parent, in the parent's frame

  int joint_count() const { return static_cast<int>(names.size()); }
  friend bool operator==(const Skeleton&, const Skeleton&) = default;
};

// One pose of such a skeleton: per joint the translation and rotation relative to its parent.
// `translations[j]` is the skeleton's offset unless the source moves that joint (the root always).
// Sized once per session; hot-path functions never resize it.
struct RigPose {
  std::vector<Vec3> translations;
  std::vector<Quat> rotations;

  explicit RigPose(const Skeleton& skeleton)
      : translations(skeleton.offsets), rotations(skeleton.offsets.size(), Quat::Identity()) {}
  RigPose() = default;
};

}  // namespace styled::rig
