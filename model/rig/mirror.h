#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "model/base/realtime.h"
#include "model/rig/binding.h"
#include "model/rig/tail.h"

namespace styled::rig {

// Exchanges left and right of one bound skeleton's poses, by a reflection through the plane x = 0
// of the canonical axes. For joint j with pair p, the change from the T-pose relative to the parent
// is the reflected one of p: with rest world rotations R, the half turn N about the left axis, and
// parents a and b of j and p, the local rotation is R_a^-1 N R_b l_p R_p^-1 N^-1 R_j. Only local
// rotations are used, so that a joint that is not tracked (NaN) makes no joint NaN but its pair.
//
// Pairs are, in this order: canonical joints (body::MirrorJoint), fingers, eyes and jaw; joints
// above such a pair, if both ways up have as many; and, among the children of a pair, joints at
// each other's reflected place in the T-pose. A joint without a pair has the T-pose's rotation
// relative to its parent. If the ways up from j and p differ, e.g. by a twist joint on one side,
// the joints between are composed.
//
// Binding::Bind of the mirrored pose is body::Mirror of the bound pose, in every joint that both
// sides have. Mirroring twice gives the pose back if every joint has a pair. Signs of quaternions
// stay continuous, because the mirrored ones are a linear function of the given ones. Immutable
// after construction, which allocates; any number of threads. Pinned by
// tests/unit/rig/mirror_test.cpp.
class MirrorMap {
 public:
  MirrorMap() = default;  // of no joints
  MirrorMap(const Binding& binding, const TailMap& tail);

  // The joint whose motion the joint has in the mirror: itself on the middle line, -1 for none.
  int pair(int joint) const { return pair_[static_cast<std::size_t>(joint)]; }

  // Writes all rotations and joint 0's position of `mirrored`; its other translations must be the
  // skeleton's offsets, and stay. It must not be `pose`; both must have the skeleton's joint count.
  STYLED_REALTIME void Apply(const RigPose& pose, RigPose& mirrored) const noexcept;

  // The reflected world pose of an object, in the skeleton's axes. The object's own axes are
  // reflected like the world's, so that the identity stays the identity. Exact (signs change) if
  // left is an axis of the skeleton.
  STYLED_REALTIME Vec3 Reflected(const Vec3& position) const noexcept;
  STYLED_REALTIME Quat Reflected(const Quat& rotation) const noexcept;

 private:
  struct Range {
    std::size_t first = 0, last = 0;
  };
  struct Link {
    int from = -1;  // the pair
    Quat before = Quat::Identity(), after = Quat::Identity();
    // In between_, parents first: the joints above `from` that are composed into it, and those
    // above the joint itself, which do not change with it.
    Range above_from, above;
  };
  void PairAbove(const Skeleton& skeleton);
  void PairByPlace(const Binding& binding);
  Link LinkOf(const Binding& binding, int joint);
  Range PathBelow(const Skeleton& skeleton, int top, int joint);
  STYLED_REALTIME Vec3 ToHips(const RigPose& pose) const noexcept;

  Vec3 left_ = Vec3::UnitX();  // in the skeleton's axes
  std::vector<int> pair_;
  std::vector<Link> links_;  // per joint
  std::vector<int> between_;
  // The joints below joint 0 down to the hips, and their offsets; empty if they are in the mirror's
  // plane in the T-pose, as the reflection of joint 0's position is then that of the hips'.
  std::vector<std::pair<std::size_t, Vec3>> to_hips_;
};

}  // namespace styled::rig
