#pragma once

#include <array>
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
  // source_joint[c]: the source joint for canonical joint c, or -1 if the source has none.
  std::array<int, body::kJointCount> source_joint;
  // World rotation of every *source* joint (source axes) when the skeleton stands in the T-pose,
  // facing the source's forward.
  std::vector<Quat> rest_rotations;
  // The rotation from source axes to +Y up, +Z forward, +X left. Decoders convert left-handed
  // sources to right-handed ones first.
  Quat canonical_from_source = Quat::Identity();
};

// Transfers poses between a source skeleton and the canonical humanoid. A joint's rotation is
// transferred as its world-space change from the T-pose, which both skeletons share. Bind composes
// source joints between two mapped ones into the next mapped descendant. Unbind keeps them as
// received and solves that descendant against them. Joints beyond the last mapped one (fingers,
// face) pass through unchanged. Bind followed by Unbind of the same pose gives the source back.
// Immutable after Make; any number of threads. Pinned by tests/unit/rig/binding_test.cpp.
class Binding {
 public:
  // Refuses: an empty skeleton; more than kMaxSourceJoints joints; a parent that does not precede
  // its child; an offset that is not finite or beyond a million units; a rest rotation that is not
  // of unit length; a source joint that does not exist or is mapped twice; missing hips, head,
  // upper or lower arm, upper or lower leg; neither a foot nor toes (the error names missing
  // joints); a T-pose whose feet are not below its hips.
  static Result<Binding> Make(BindingSpec spec);

  const Skeleton& skeleton() const { return spec_.skeleton; }
  const BindingSpec& spec() const { return spec_; }
  // Canonical metres per source unit: the canonical hips' height above the toes, divided by the
  // source's height above its lowest toe, both in the T-pose. Uses the feet if the source has no
  // toes.
  float scale() const { return scale_; }

  // `source` must have the skeleton's joint count and unit quaternions. Writes all of `pose`: local
  // unit rotations with w >= 0 (the caller makes the sign continuous over time), the identity for
  // canonical joints that the source lacks, and the hips' position in canonical metres.
  STYLED_REALTIME void Bind(const RigPose& source, body::Pose& pose) const noexcept;
  // Writes all of `out`: the rotations of mapped joints and the hips' translation come from `pose`,
  // everything else from `received`. Each mapped rotation has the sign that is nearer to the
  // received one. `out` must not be `received`; both must have the skeleton's joint count.
  STYLED_REALTIME void Unbind(const body::Pose& pose, const RigPose& received,
                              RigPose& out) const noexcept;

  // The position of joint 0, in source units and axes, that puts the hips where `pose` has them if
  // every other joint is at the skeleton's offset. Needed where only joint 0's position is sent.
  STYLED_REALTIME Vec3 RootPosition(const RigPose& pose) const noexcept;

 private:
  Binding() = default;
  BindingSpec spec_;
  float scale_ = 1.0F;
  std::vector<int> canonical_joint_;  // per source joint; -1 if not mapped
  std::vector<int> hips_chain_;       // source joints from the root to the hips, both included
};

// World positions and rotations of `pose` in source units and axes. Vectors are resized.
void WorldTransforms(const Skeleton& skeleton, const RigPose& pose, std::vector<Vec3>& positions,
                     std::vector<Quat>& rotations);

// Finds the T-pose's rest rotations (world, source axes, one per source joint) from a standing pose
// (source axes; looking ahead, soles flat on the floor). Every bone is swung onto its direction in
// the T-pose by the shortest arc that remains after its parent's swing, so that no twist
// accumulates along a limb. Exceptions: hips and chest are aligned by two axes; hands, toes and
// unmapped joints inherit their parent's swing; feet and head only turn about the vertical, because
// they are level and upright already. A bone of no length uses the direction to the next mapped
// descendant. Every canonical joint except the hips and the upper legs may be missing. Allocates;
// any thread.
std::vector<Quat> RestBySwing(const Skeleton& skeleton,
                              const std::array<int, body::kJointCount>& source_joint,
                              const RigPose& standing, const Quat& canonical_from_source);

}  // namespace styled::rig
