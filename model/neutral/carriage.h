#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/gait/curve.h"

namespace styled::neutral {

// A person's carriage: the mean rotation of each joint of the canonical humanoid relative to its
// parent, the hips' relative to the body's heading (body::Heading_rad). Unit quaternions; identity
// is the T-pose.
struct Carriage {
  std::array<body::Quat, body::kJointCount> rotations;

  Carriage() { rotations.fill(body::Quat::Identity()); }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(rotations); }
  friend bool operator==(const Carriage& a, const Carriage& b) {
    return std::ranges::equal(a.rotations, b.rotations, [](const auto& one, const auto& other) {
      return one.coeffs() == other.coeffs();
    });
  }
};

// How people walk and run in neutral, by gait phase.
struct Gaits {
  gait::Curve walking, running;
};

// The carriage of the performers that a network was trained on, in its neutral style, while they
// stand with hanging arms, walk and run. Symmetric, since training mirrors clips. Also the mean
// speeds at which they walk and run, canonical metres per second, which separate walking from
// running; the defaults are those of most people. Weights files contain the carriages
// (model/net/FORMAT.md) and the speeds, as neutral's.
struct Reference {
  Carriage standing, walking, running;
  float walk_mps = 1.2F, run_mps = 2.8F;
  // Only for a family that changes gaits by their phase: the gaits of many people, which need not
  // be those of the carriages above. With them, a performer's own gaits are learned.
  std::optional<Gaits> gaits;
};

}  // namespace styled::neutral
