#pragma once

#include <Eigen/Core>
#include <array>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::gait {

// A cyclic motion of all joints as a function of the gait phase (Phase::phase_rad).
// Harmonics of a stride. They explain 0.83 of the movement of 15 styles' walks, 2 harmonics 0.78, 5
// harmonics 0.84.
inline constexpr int kHarmonics = 3;
inline constexpr int kTerms = 1 + 2 * kHarmonics;

// 1, cos(phase) .. cos(3 phase), sin(phase) .. sin(3 phase).
using Terms = Eigen::Matrix<float, kTerms, 1>;
STYLED_REALTIME Terms TermsAt(float phase_rad) noexcept;

using Rotations = std::array<body::Quat, body::kJointCount>;

// Rotation vectors of all joints: x, y, z of joint 0, then of joint 1, ...; rad. The last number is
// padding, 0.
inline constexpr int kNumbers = 3 * body::kJointCount + 1;
using Vectors = Eigen::Matrix<float, kNumbers, 1>;
// A Fourier series of rotation vectors: a column per term.
using Series = Eigen::Matrix<float, kNumbers, kTerms>;

// Local rotations of the canonical humanoid, the hips' relative to the heading (body::Heading_rad).
// At phase p, joint j is mean_j exp(series_j(p)).
struct Curve {
  Rotations mean;
  Series series = Series::Zero();

  Curve() { mean.fill(body::Quat::Identity()); }
  // The rotation vectors about the mean.
  STYLED_REALTIME Vectors VectorsAt(const Terms& terms) const noexcept { return series * terms; }
  STYLED_REALTIME Rotations At(const Terms& terms) const noexcept;
  // See model/base/checkpoint.h. Refuses means that are no rotations, and numbers that are not
  // finite.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;
};

// The rotations of a pose with its heading (body::Heading_rad), as in Curve.
STYLED_REALTIME Rotations HeadingRelative(const body::Pose& pose, float heading_rad) noexcept;
// The rotation vectors from `mean` to `rotations`: log(mean_j^-1 rotation_j).
STYLED_REALTIME Vectors VectorsAbout(const Rotations& mean, const Rotations& rotations) noexcept;

// Exchanges left and right (body::Mirror). Half a stride lies between a gait and its mirror image,
// so that odd harmonics change their sign.
STYLED_REALTIME Rotations Mirrored(const Rotations& rotations) noexcept;
STYLED_REALTIME Series Mirrored(const Series& series) noexcept;
STYLED_REALTIME Terms MirrorSigns() noexcept;  // of the terms: 1 or -1

inline auto VectorOf(const Vectors& vectors, int joint) { return vectors.segment<3>(3 * joint); }

}  // namespace styled::gait
