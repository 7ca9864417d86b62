#pragma once

#include <array>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::erd {

// The network's input for one pose (Style-ERD's r, p, v and the hips height), in this order:
//   [0, 84)    r: local rotations x,y,z,w per joint, the hips' relative to the heading, each on
//              the hemisphere of FeatureParameters::hemisphere
//   [84, 147)  p: joint positions in the heading frame, m; origin at the hips
//   [147, 210) v: joint velocities in the heading frame, m/s, root motion included: difference to
//              the pose one network period ago
//   [210]      hips height above the floor (y = 0), m
// Training data and live frames use the same code. Pinned by tests/unit/net/erd/features_test.cpp.
inline constexpr int kRotationFeatures = 4 * body::kJointCount;
inline constexpr int kPositionFeatures = 3 * body::kJointCount;
inline constexpr int kVelocityFeatures = 3 * body::kJointCount;
inline constexpr int kPositionBegin = kRotationFeatures;
inline constexpr int kVelocityBegin = kPositionBegin + kPositionFeatures;
inline constexpr int kHipsHeightIndex = kVelocityBegin + kVelocityFeatures;
inline constexpr int kFeatureCount = kHipsHeightIndex + 1;
using Features = std::array<float, kFeatureCount>;

// Read from the weights' metadata.
struct FeatureParameters {
  float rate_hz = 30.0F;        // the network's own rate; > 0
  float heading_tau_s = 0.25F;  // time constant of the causal heading filter; 0 = unfiltered
  std::array<body::Quat, body::kJointCount> hemisphere;  // r is flipped to dot(r, hemisphere) >= 0

  FeatureParameters() { hemisphere.fill(body::Quat::Identity()); }
};

// The state that one stream of poses at the network's rate keeps between frames. Value type, 1 kB,
// one per recurrent state; one thread at a time.
struct FeatureState {
  bool started = false;
  float heading_cos = 1.0F, heading_sin = 0.0F;           // the filtered heading's direction
  std::array<body::Vec3, body::kJointCount> positions_m;  // world, one period ago

  FeatureState() { positions_m.fill(body::Vec3::Zero()); }
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(started, heading_cos, heading_sin, positions_m);
  }
};

// Computes the features of `pose` and advances `state` by one network period. The first frame after
// construction has v = 0 and an unfiltered heading. Returns the filtered heading in use (rad).
STYLED_REALTIME float ComputeFeatures(const body::Pose& pose, const FeatureParameters& parameters,
                                      FeatureState& state, Features& features) noexcept;

}  // namespace styled::erd
