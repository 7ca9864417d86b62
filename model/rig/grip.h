#pragma once

#include <array>
#include <cstdint>

#include "model/base/realtime.h"
#include "model/rig/wrists.h"

// An object in a hand: a sword that the rig tracks keeps its pose relative to the hand that holds
// it, wherever a style moves that hand. Pure functions; any thread; no allocation. Pinned by
// tests/unit/rig/grip_test.cpp and, through the daemon,
// tests/unit/daemon/perform/performer/props_test.cpp.
namespace styled::rig {

// The hand that holds an object. kAuto: the hand near it, by its distance from the wrist.
enum class Hand : std::uint8_t { kAuto, kNone, kLeft, kRight };

// The distance of an object's origin from a wrist up to which the hand holds it, and beyond which
// it does not; smooth between. The origin of a tracked object is its pivot, or the centre of its
// markers: in the grip, 0.1 m from the wrist, or up to a forearm's length off it. Canonical metres,
// so that they fit children and giants.
inline constexpr float kHeld_m = 0.35F, kLetGo_m = 0.5F;

// How much each hand holds an object, left and right: 0 .. 1 each, at most 1 together; the rest is
// fixed in the room.
struct Grip {
  std::array<float, 2> share{};
  float held() const { return share[0] + share[1]; }
};

// The grip on an object. Of two hands near it the nearer one has almost all: 0.98 if it is 0.1 m
// and the farther one 0.3 m away. A continuous function of the poses, without memory. A hand that
// the skeleton lacks holds nothing.
STYLED_REALTIME Grip GripOf(const Placed& object, const WristPair& wrists, Hand hand) noexcept;

// The object's pose when the wrists move from `from` to `to`. Each hand's contribution is as if the
// object were welded to it; without a hand the object stays in place. The contributions are mixed
// by their shares (positions linear, rotations along the shorter arcs). Exactly `object` if nothing
// is held. A hand without a `to` holds nothing. The rotation has unit length.
STYLED_REALTIME Placed Carry(const Placed& object, const Grip& grip, const WristPair& from,
                             const WristPair& to) noexcept;

}  // namespace styled::rig
