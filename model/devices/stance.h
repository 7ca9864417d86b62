#pragma once

#include <span>
#include <string_view>

#include "model/body/pose.h"

namespace styled::devices {

using body::Quat;
using body::Vec3;

// A device while its performer stands in the T-pose. Right-handed, +Y up, metres; the floor is
// y = 0, the heading is any.
struct Seen {
  static constexpr int kUnknown = -1;
  Vec3 position_m = Vec3::Zero();
  Quat rotation = Quat::Identity();
  bool has_rotation = false;
  // It is known to be on the head, and to have the head's rotation: a head-mounted display.
  bool is_head = false;
  bool at_joint = false;  // it is exactly at its joint, not at a usual place near it
  int part = kUnknown;    // body::Joint
  bool guessed = false;   // set by GuessParts
};

// Assigns a part to each device without one whose place fits a free part, by height and side, as
// VRChat does: head, hands, elbows, hips, chest, knees, feet. A device farther than 0.3 m (of a
// performer of the canonical height) from every free place gets no part. Without a head-mounted
// display, front and back are a guess: the performer is assumed to look into the half of the space
// around +Z. Pinned by tests/unit/devices/stance_test.cpp.
void GuessParts(std::span<Seen> devices);

// How the performer stands.
struct Stance {
  float heading = 0;           // about +Y from +Z to the left, radians
  float scale = 1;             // the performer's size, as a share of the canonical humanoid's
  Vec3 place_m{0, 0, 0};       // between the feet, y = 0
  std::string_view faced_by;   // the source of the heading, for messages
  std::string_view scaled_by;  // the source of the scale
};
// The heading: from the hands, which are far apart, else from the head's rotation, else from the
// elbows, the feet or the knees, where each centimetre costs degrees, else 0. The scale: from the
// head's height, else the distance of the hands, else the hips' height, else 1. The place: between
// the hands, else the feet, else below the hips, else below the head.
Stance FindStance(std::span<const Seen> devices);

}  // namespace styled::devices
