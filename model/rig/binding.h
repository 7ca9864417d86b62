#pragma once

#include <array>
#include <string>
#include <vector>

#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/body/pose.h"
#include "model/rig/skeleton.h"

namespace styled::rig {

// How one source skeleton corresponds to the canonical humanoid. Made once per session, then
// immutable and shared.
struct BindingSpec {
  Skeleton skeleton;
  // source_joint[c]: the source joint for canonical joint c, or -1 where the source has none.
  std::array<int, body::kJointCount> source_joint;
  // World rotation of every *source* joint (source axes) when the skeleton stands in the T-pose,
  // facing the source's forward.
  std::vector<Quat> rest_rotations;
  // Rotation that takes source axes to +Y up, +Z forward, +X left. Mirrored (left-handed) sources
  // are made right-handed by their decoder.
  Quat canonical_from_source = Quat::Identity();
};

// Transfers poses between a source skeleton and the canonical humanoid by the world-space change
// from the common T-pose. Source joints between two mapped ones are composed into the next mapped
// descendant coming in, and kept as received going out, with that descendant solved against them;
// what lies beyond (fingers, face) passes untouched. Bind then Unbind of the same pose gives the
// source back. Immutable after Make; any number of threads. Pinned by
// tests/unit/rig/binding_test.cpp.
class Binding {
 public:
  // Refuses: an empty skeleton, a parent that does not precede its child, a rest rotation that is
  // not of unit length, no hips, or a missing upper/lower leg, upper/lower arm, or head (names them).
  static Result<Binding> Make(BindingSpec spec);

  const Skeleton& skeleton() const { return spec_.skeleton; }
  const BindingSpec& spec() const { return spec_; }
  // Canonical metres per source unit: hips height over hips height.
  float scale() const { return scale_; }

  // `source` must have the skeleton's joint count.
  STYLED_REALTIME void Bind(const RigPose& source, body::Pose& pose) const noexcept;
  // Writes all of `out`: mapped joints from `pose`, all others from `received`. `out` may not be
  // `received`; both have the skeleton's joint count.
  STYLED_REALTIME void Unbind(const body::Pose& pose, const RigPose& received,
                              RigPose& out) const noexcept;

 private:
  Binding() = default;
  BindingSpec spec_;
  float scale_ = 1.0F;
  std::vector<int> canonical_joint_;  // per source joint, -1 where unmapped
};

// World positions and rotations of `pose` in source units and axes. Vectors are resized.
void WorldTransforms(const Skeleton& skeleton, const RigPose& pose, std::vector<Vec3>& positions,
                     std::vector<Quat>& rotations);

// T-pose rest rotations found by swinging every bone of a standing pose (source axes) onto its
// T-pose direction: leaves inherit their parent's swing; hips and chest use two axes.
std::vector<Quat> RestBySwing(const Skeleton& skeleton,
                              const std::array<int, body::kJointCount>& source_joint,
                              const RigPose& standing, const Quat& canonical_from_source);

}  // namespace styled::rig
