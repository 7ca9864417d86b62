#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "model/base/realtime.h"
#include "model/rig/binding.h"

namespace styled::rig {

// The world pose of a hand or an object: world from it, in canonical axes (+Y up, +Z forward, +X
// left) and in metres of the canonical humanoid's scale (Binding::scale).
struct Placed {
  Vec3 position_m = Vec3::Zero();
  Quat rotation = Quat::Identity();
};

// Converts a world pose from a bound skeleton's axes and units to canonical ones, and back. An
// object's own axes are converted like the world's, so that the identity stays the identity.
STYLED_REALTIME Placed ToCanonical(const Binding& binding, const Vec3& position,
                                   const Quat& rotation) noexcept;
STYLED_REALTIME void FromCanonical(const Binding& binding, const Placed& placed, Vec3& position,
                                   Quat& rotation) noexcept;

// The wrists of a pose: left, right. A rotation is the world-space change from the T-pose, as that
// of the canonical humanoid's hands. Empty: the skeleton has no joint for that hand.
using WristPair = std::array<std::optional<Placed>, 2>;
inline constexpr std::size_t kLeftWrist = 0, kRightWrist = 1;

// Finds the wrists of one bound skeleton by forward kinematics along the arms. Immutable after
// construction, which allocates; any number of threads. Pinned by tests/unit/rig/grip_test.cpp.
class Wrists {
 public:
  // The binding must outlive it.
  explicit Wrists(const Binding& binding);

  // `rotations`: local, of all joints. `root`: joint 0's position in the skeleton's units; every
  // other joint is at its offset, as subscribers draw it.
  STYLED_REALTIME WristPair Read(const Vec3& root, std::span<const Quat> rotations) const noexcept;

 private:
  const Binding* binding_;
  std::array<std::vector<std::size_t>, 2> chains_;  // from the root to the hand; empty: no hand
};

// The wrists of the canonical humanoid itself.
STYLED_REALTIME WristPair WristsOf(const body::Pose& pose) noexcept;

}  // namespace styled::rig
