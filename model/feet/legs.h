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

// One joint in space: position in canonical metres and axes; the rotation takes the joint's own
// frame, whatever it is, to canonical axes.
struct Placed {
  Vec3 position_m;
  Quat rotation;
};

// The legs of a skeleton: which joints, and all that stands between them and the root (locators,
// twist joints). Made once, immutable.
class Legs {
 public:
  // Indices into joints(); toes -1 where the skeleton has none. A leg whose foot is missing, or
  // whose joints do not hang below one another, is not `resolved` and is left alone.
  struct Leg {
    bool resolved = false;
    int upper = -1, lower = -1, foot = -1, toes = -1;
    Vec3 hinge_in_upper = Vec3::UnitX();  // the knee's anatomical axis in the upper leg's frame:
                                          // flexing turns the shank about it, positively
    Vec3 across_foot = Vec3::UnitX();     // to the body's left in the T-pose, in the foot's frame
    float ankle_above_toes_m = 0;         // in the T-pose; 0 without toes
  };

  explicit Legs(const rig::Binding& binding);

  const Leg& leg(int side) const { return legs_[static_cast<std::size_t>(side)]; }
  int hips() const { return hips_; }  // index into joints()
  // The skeleton's joints that matter, parents first; parents() index the same list, -1 the root's.
  const std::vector<int>& joints() const { return joints_; }
  const std::vector<int>& parents() const { return parents_; }
  float metres_per_unit() const { return metres_per_unit_; }
  const Quat& canonical_from_source() const { return canonical_from_source_; }

  // Places joints() in space. `placed` has joints().size() entries; rotations of `pose` are unit.
  STYLED_REALTIME void Place(const PoseView& pose, std::span<Placed> placed) const noexcept;
  // The rotation that a joint's local one is relative to.
  STYLED_REALTIME Quat ParentRotation(int index, std::span<const Placed> placed) const noexcept;

 private:
  std::vector<int> joints_, parents_;
  std::array<Leg, kLegs> legs_;
  int hips_ = 0;
  float metres_per_unit_ = 1;
  Quat canonical_from_source_ = Quat::Identity();
};

// The canonical humanoid bound to itself, so that its own feet can be held.
rig::Binding HumanoidBinding();

}  // namespace styled::feet
