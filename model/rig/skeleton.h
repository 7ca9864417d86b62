#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
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

  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(translations, rotations); }
};

// Reflection through the plane x = 0: turns left-handed axes into right-handed ones and back.
inline Vec3 Mirrored(const Vec3& v) { return {-v.x(), v.y(), v.z()}; }
inline Quat Mirrored(const Quat& q) { return {q.w(), q.x(), -q.y(), -q.z()}; }
inline void Mirror(RigPose& pose) noexcept {
  for (Vec3& translation : pose.translations) translation.x() = -translation.x();
  for (Quat& rotation : pose.rotations) {
    rotation.y() = -rotation.y();
    rotation.z() = -rotation.z();
  }
}

// A skeleton as its rig reports it: the fields of the Body message
// (proto/styled/v1/body.proto).
struct RigBody {
  Skeleton skeleton;          // units and axes of the rig
  std::vector<Quat> rest;     // world rotations in the T-pose; empty: by dialect
  float metres_per_unit = 0;  // 0 = unknown
  std::string dialect = "auto";

  friend bool operator==(const RigBody& a, const RigBody& b) {
    const auto same = [](const Quat& p, const Quat& q) { return p.coeffs() == q.coeffs(); };
    return a.skeleton == b.skeleton && std::ranges::equal(a.rest, b.rest, same) &&
           a.metres_per_unit == b.metres_per_unit && a.dialect == b.dialect;
  }
};

}  // namespace styled::rig
