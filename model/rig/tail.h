#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "model/base/realtime.h"
#include "model/body/humanoid.h"
#include "model/rig/binding.h"

namespace styled::rig {

// The joints that a body may have beyond the canonical humanoid, as VRM 1.0 has them: the tail.
// Three for each finger (thumb, index, middle, ring, little; left, then right), the eyes, the jaw.
inline constexpr int kFingersPerHand = 5, kFingerJoints = 3;
inline constexpr int kHandTail = kFingersPerHand * kFingerJoints;
enum TailJoint : int {
  kTailLeftThumb = 0,
  kTailRightThumb = kHandTail,
  kTailLeftEye = 2 * kHandTail,
  kTailRightEye,
  kTailJaw,
  kTailCount
};
// VRM 1.0's names: leftThumbMetacarpal, leftThumbProximal, leftThumbDistal, leftIndexProximal, ...
extern const std::array<std::string_view, kTailCount> kTailNames;

// The joint before it in its finger; -1 for a finger's first joint, eyes and jaw.
constexpr int TailBefore(int joint) {
  return joint < kTailLeftEye && joint % kFingerJoints > 0 ? joint - 1 : -1;
}

// The canonical joint that a tail joint hangs from: a hand or the head.
constexpr int TailAnchor(int joint) {
  if (joint >= kTailLeftEye) return body::kHead;
  return joint < kTailRightThumb ? body::kLeftHand : body::kRightHand;
}

// Per tail joint the skeleton's joint, or -1.
using TailMap = std::array<int, kTailCount>;
constexpr TailMap NoTail() {
  TailMap none{};
  none.fill(-1);
  return none;
}

// The tail by the naming conventions of the field (VRM/Unity, Mixamo/HIK, Xsens, Rokoko, Motive,
// Unreal, Biped, Rigify, Character Creator, SMPL-X, ...; the tables are in joint_names.cpp). A
// finger with numbered joints needs its first two joints, because the joints of bodies with one
// stiff joint per finger mean something else. Allocates; any thread. Pinned by
// tests/unit/rig/tail_names_test.cpp.
TailMap MapTailNames(const Skeleton& skeleton);

// The same for a skeleton whose humanoid is known: `joints` per canonical joint, -1 if missing.
// Fingers that no convention names are found below the hands: chains of two joints and more, by any
// word for a finger in their names, or, where five chains have none, by their order across the palm
// in the zero pose. Allocates; any thread. Pinned by tests/unit/rig/find_tail_test.cpp.
TailMap FindTail(const Skeleton& skeleton, const std::array<int, body::kJointCount>& joints);

// The joints that both have.
TailMap Both(const TailMap& map, const TailMap& other);

// The tail of one bound skeleton. A joint's rotation is its world-space change from the T-pose
// relative to that of its parent, as in the canonical humanoid: the identity in the T-pose. The
// parent is the joint before it in its finger, else the hand or the head; joints of the skeleton
// between the two (carpals, a face) are composed into the joint. The tail therefore depends on
// nothing above the hand: on a styled wrist the fingers keep their pose. Immutable after Make; any
// number of threads. Pinned by tests/unit/rig/tail_test.cpp.
class Tail {
 public:
  struct Joint {
    int joint = 0;                 // TailJoint
    int parent = 0;                // a canonical joint, or body::kJointCount + an earlier place
    Vec3 offset_m = Vec3::Zero();  // from the parent in the T-pose, canonical axes and scale
  };

  Tail() = default;  // no joints
  // The tail of `binding`'s skeleton by `map`. Leaves out a joint that is not below the joint it
  // hangs from, or that the humanoid has. Allocates.
  static Tail Make(const Binding& binding, const TailMap& map);
  // The same for a BindingSpec that may be incomplete: a hand and the joints below it. `scale`:
  // metres per unit of its skeleton.
  static Tail Make(const BindingSpec& spec, float scale, const TailMap& map);

  const std::vector<Joint>& joints() const { return joints_; }
  std::size_t size() const { return joints_.size(); }
  // The joints as a map, without those that were left out.
  const TailMap& map() const { return map_; }

  // Reads the tail of a pose, local rotations of the skeleton's joints. `tail` must have size()
  // rotations: the former ones, for continuity in sign; unit length afterwards.
  STYLED_REALTIME void Read(std::span<const Quat> pose, std::span<Quat> tail) const noexcept;
  // Sets the tail's joints of `pose`, local rotations of the skeleton's joints, to `tail`. Joints
  // between a tail joint and its parent stay as they are.
  STYLED_REALTIME void Write(std::span<const Quat> tail, std::span<Quat> pose) const noexcept;
  // The same for only the joint at a place of joints().
  STYLED_REALTIME void Write(std::size_t place, const Quat& turn,
                             std::span<Quat> pose) const noexcept;

 private:
  // The rotation in the skeleton's axes is before * tail * after.
  struct Link {
    int joint = 0;          // the skeleton's
    std::size_t first = 0;  // the joints between, parents first, are between_[first, last)
    std::size_t last = 0;
    Quat before = Quat::Identity(), after = Quat::Identity();
  };
  STYLED_REALTIME Quat Between(const Link& link, std::span<const Quat> pose) const noexcept;

  std::vector<Joint> joints_;
  std::vector<Link> links_;
  std::vector<int> between_;
  TailMap map_ = NoTail();
};

}  // namespace styled::rig
