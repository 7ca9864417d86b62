#pragma once

#include <optional>
#include <string>

#include "model/base/status.h"
#include "model/rig/wrists.h"

namespace styled::player {

// An object that a simulated rig tracks beside its performers: in the first performer's hand, or at
// a fixed place of the room.
struct PropSpec {
  std::string name;
  std::optional<std::size_t> wrist;       // rig::kLeftWrist, rig::kRightWrist; empty: at `place_m`
  rig::Vec3 place_m = rig::Vec3::Zero();  // canonical axes
};

// Parses "sword=right_hand", "torch=left_hand" or "chair=1,0,2" (metres: left, up, forward). Errors
// repeat the text and say what was expected.
Result<PropSpec> ParseProp(const std::string& text);

// Its pose for the given wrists: 0.1 m before the wrist in the direction of the fingers, rotated
// with the hand, or at its fixed place without rotation. Empty if the performer has no such hand.
std::optional<rig::Placed> PlaceOf(const PropSpec& prop, const rig::WristPair& wrists);

}  // namespace styled::player
