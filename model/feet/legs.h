#pragma once

#include <array>
#include <span>
#include <vector>

#include "model/base/realtime.h"
#include "model/rig/binding.h"

namespace styled::feet {

using body::Quat;
using body::Vec3;

inline constexpr int kLegs = 2;  // left, right

// A pose as local translations and rotations, one per joint of its skeleton.
struct PoseView {
  std::span<const Vec3> translations;
  std::span<const Quat> rotations;
};
struct MutablePoseView {
  std::span<Vec3> translations;
  std::span<Quat> rotations;

  operator PoseView() const { return {translations, rotations}; }
};

// The world transform of one joint: position in canonical metres and axes; the rotation is from the
// joint's own frame to canonical axes.
struct Placed {
  Vec3 position_m;
  Quat rotation;
};

// The legs of a skeleton: their joints, and all joints between them and the root (locators, twist
// joints included). Made once, immutable.
class Legs {
 public:
  // Indices into joints(); `toes` is -1 if the skeleton has none. A leg without a foot, or whose
  // joints are not a chain, is not `resolved` and is never changed.
  struct Leg {
    bool resolved = false;
    int upper = -1, lower = -1, foot = -1, toes = -1;
    // the knee's axis, in the upper leg's frame; flexion turns the shank positively
    Vec3 hinge_in_upper = Vec3::UnitX();
    Vec3 across_foot = Vec3::UnitX();  // the body's left in the T-pose, in the foot's frame
    float ankle_above_toes_m = 0;      // in the T-pose; 0 without toes
  };

  explicit Legs(const rig::Binding& binding);

  const Leg& leg(int side) const { return legs_[static_cast<std::size_t>(side)]; }
  int hips() const { return hips_; }  // index into joints()
  // The joints in use, parents first. parents() holds indices into the same list, -1 for the root.
  const std::vector<int>& joints() const { return joints_; }
  const std::vector<int>& parents() const { return parents_; }
  float metres_per_unit() const { return metres_per_unit_; }
  const Quat& canonical_from_source() const { return canonical_from_source_; }

  // Computes the world transforms of joints(). `placed` has joints().size() entries; the rotations
  // of `pose` are unit quaternions.
  STYLED_REALTIME void Place(const PoseView& pose, std::span<Placed> placed) const noexcept;
  // The world rotation that the joint's local rotation is relative to.
  STYLED_REALTIME Quat ParentRotation(int index, std::span<const Placed> placed) const noexcept;

 private:
  std::vector<int> joints_, parents_;
  std::array<Leg, kLegs> legs_;
  int hips_ = 0;
  float metres_per_unit_ = 1;
  Quat canonical_from_source_ = Quat::Identity();
};

// The canonical humanoid bound to itself, for holding the feet of canonical poses. Allocates.
rig::Binding HumanoidBinding();

}  // namespace styled::feet
