#pragma once

#include <array>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/net/stylizer.h"

namespace styled::stgcn {

// The network's input and output for one pose, kChannels numbers per joint, joint by joint in the
// order of body::Joint:
//   [0, 3) position in the heading frame, m: x to the performer's left and z forward from the point
//          below the hips, y above the floor. The hips' x and z are 0 in every pose.
//   [3, 7) rotation x,y,z,w relative to the heading frame (not to the parent), on the hemisphere of
//          FeatureParameters::hemisphere
// Nothing here is a difference over time, so only the heading filter depends on a stream's rate.
// After Park et al. 2021, section 3.1; unlike theirs, heights are true, and the heading is causal.
// Training and runtime use the same code. Pinned by tests/unit/net/stgcn/features_test.cpp.
inline constexpr int kPositionChannels = 3;
inline constexpr int kRotationChannels = 4;
inline constexpr int kChannels = kPositionChannels + kRotationChannels;
inline constexpr int kFeatureCount = kChannels * body::kJointCount;
using Features = std::array<float, kFeatureCount>;

// Read from the weights' metadata.
struct FeatureParameters {
  float rate_hz = 30.0F;        // of the stream of poses; > 0
  float heading_tau_s = 0.25F;  // time constant of the causal heading filter; 0 = unfiltered
  std::array<body::Quat, body::kJointCount> hemisphere;  // rotations: dot(q, hemisphere) >= 0

  FeatureParameters() { hemisphere.fill(body::Quat::Identity()); }
};

// The state of one stream of poses between frames. One thread at a time.
struct HeadingState {
  bool started = false;
  float cosine = 1.0F, sine = 0.0F;  // the filtered heading's direction

  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(started, cosine, sine); }
};

// Computes the features of `pose` and advances `state` by one period. The first frame's heading is
// unfiltered. Returns the filtered heading in use (rad).
STYLED_REALTIME float ComputeFeatures(const body::Pose& pose, const FeatureParameters& parameters,
                                      HeadingState& state, Features& features) noexcept;

// The pose that the features' rotations and the hips' height describe, turned to `heading_rad` and
// with the hips above x = z = 0. Positions of other joints are not used: they follow from the
// rotations. Rotations need not have length 1; one shorter than 1e-6 counts as the identity.
STYLED_REALTIME void PoseOf(const Features& features, float heading_rad, body::Pose& pose) noexcept;

// The same as a network's output: the hips stay relative to the heading, velocities are 0.
STYLED_REALTIME void ToDecoded(const Features& features, net::Decoded& out) noexcept;

// The features of the mirrored pose (body::Mirror): joints of left and right swapped, reflected at
// x = 0. `out` may be `features`. Keeps the hemisphere where that is its own mirror image, as the
// mean of clips and their mirror images is.
STYLED_REALTIME void MirrorFeatures(const Features& features, Features& out) noexcept;

// The hemisphere that the mean of the features defines.
void SetHemisphere(const Features& mean, FeatureParameters& parameters);

}  // namespace styled::stgcn
