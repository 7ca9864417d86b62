#pragma once

#include <array>
#include <string>
#include <vector>

#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/body/pose.h"
#include "model/rig/skeleton.h"

namespace styled::rig {

// Bind and Unbind keep one world rotation per source joint on the stack; Make refuses more.
inline constexpr int kMaxSourceJoints = 256;

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
  // Refuses: an empty skeleton, one of more than kMaxSourceJoints, a parent that does not precede
  // its child, an offset that is not finite or beyond a million units, a rest rotation that is not
  // of unit length, a source joint that does not exist or is given twice, no hips, a missing
  // upper/lower leg, upper/lower arm, or head, neither feet nor toes (names them), or a T-pose
  // whose feet are not below its hips.
  static Result<Binding> Make(BindingSpec spec);

  const Skeleton& skeleton() const { return spec_.skeleton; }
  const BindingSpec& spec() const { return spec_; }
  // Canonical metres per source unit: the canonical hips' height above the lowest toe (above the
  // lowest foot where the source has no toes) over the source's, both in T-pose.
  float scale() const { return scale_; }

  // `source` must have the skeleton's joint count and unit quaternions. Writes local rotations of
  // unit length with w >= 0 (a stream or clip makes them continuous in sign) and the hips'
  // position; identity for canonical joints that the source lacks.
  STYLED_REALTIME void Bind(const RigPose& source, body::Pose& pose) const noexcept;
  // Writes all of `out`: mapped joints' rotations and the hips' translation from `pose`, all else
  // from `received`; each mapped rotation in the sign nearer to the received one. `out` may not be
  // `received`; both have the skeleton's joint count.
  STYLED_REALTIME void Unbind(const body::Pose& pose, const RigPose& received,
                              RigPose& out) const noexcept;

  // Where joint 0 must stand for the hips to be where `pose` has them while every other joint
  // stands at the skeleton's offset: what is sent has no other position than joint 0's.
  STYLED_REALTIME Vec3 RootPosition(const RigPose& pose) const noexcept;

 private:
  Binding() = default;
  BindingSpec spec_;
  float scale_ = 1.0F;
  std::vector<int> canonical_joint_;  // per source joint, -1 where unmapped
  std::vector<int> hips_chain_;       // source joints from the root to the hips, both included
};

// World positions and rotations of `pose` in source units and axes. Vectors are resized.
void WorldTransforms(const Skeleton& skeleton, const RigPose& pose, std::vector<Vec3>& positions,
                     std::vector<Quat>& rotations);

// T-pose rest rotations (world, source axes, one per source joint) found by swinging every bone of
// a standing pose (source axes; looking ahead, soles flat on the floor) onto its T-pose direction
// by the shortest arc that is left after its parent's swing, so that no twist gathers along a limb.
// Hips and chest use two axes; hands, toes, and joints that are not mapped inherit their parent's
// swing; feet and head only turn about the vertical, because they stand flat and upright already.
// Bones of no length take the direction of the next mapped descendant. All 21 canonical joints may
// be missing but the hips and the upper legs.
std::vector<Quat> RestBySwing(const Skeleton& skeleton,
                              const std::array<int, body::kJointCount>& source_joint,
                              const RigPose& standing, const Quat& canonical_from_source);

}  // namespace styled::rig
