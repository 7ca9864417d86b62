#pragma once

#include <Eigen/Core>

#include "model/base/realtime.h"
#include "model/gait/curve.h"

// Rotations of all joints at once: the same number of each joint is side by side, so that a CPU
// works on eight joints per instruction. The results are those of body::Exp, body::Log and of
// quaternions to rounding. Pinned by tests/unit/gait/lanes_test.cpp.
namespace styled::gait {

// A number of each joint; the last ones are padding.
inline constexpr int kLanes = (body::kJointCount + 7) / 8 * 8;
using Lane = Eigen::Array<float, kLanes, 1>;

// Rotation vectors, rad; the padding is 0.
struct VectorLanes {
  Lane x, y, z;

  VectorLanes& operator+=(const VectorLanes& other) noexcept {
    x += other.x;
    y += other.y;
    z += other.z;
    return *this;
  }
  VectorLanes& operator*=(const Lane& shares) noexcept {
    x *= shares;
    y *= shares;
    z *= shares;
    return *this;
  }
};
inline VectorLanes operator+(VectorLanes a, const VectorLanes& b) noexcept { return a += b; }
inline VectorLanes operator-(const VectorLanes& a, const VectorLanes& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline VectorLanes operator*(float factor, const VectorLanes& a) noexcept {
  return {factor * a.x, factor * a.y, factor * a.z};
}

// Unit quaternions; the padding is the identity.
struct TurnLanes {
  Lane x, y, z, w;

  TurnLanes Inverse() const noexcept { return {-x, -y, -z, w}; }
};
STYLED_REALTIME TurnLanes operator*(const TurnLanes& a, const TurnLanes& b) noexcept;

STYLED_REALTIME TurnLanes ExpOf(const VectorLanes& vectors) noexcept;
// The shorter way, up to half a turn.
STYLED_REALTIME VectorLanes LogOf(const TurnLanes& turns) noexcept;
// The angles of the turns, 0 .. pi.
STYLED_REALTIME Lane AnglesOf(const TurnLanes& turns) noexcept;

STYLED_REALTIME VectorLanes ToLanes(const Vectors& vectors) noexcept;
STYLED_REALTIME TurnLanes ToLanes(const Rotations& rotations) noexcept;
STYLED_REALTIME Vectors FromLanes(const VectorLanes& vectors) noexcept;
// Normalized.
STYLED_REALTIME Rotations FromLanes(const TurnLanes& turns) noexcept;

// A Fourier series with a row per lane: x of each joint, then y, then z.
using LaneSeries = Eigen::Matrix<float, 3 * kLanes, kTerms>;
LaneSeries ToLanes(const Series& series) noexcept;
STYLED_REALTIME VectorLanes LanesAt(const LaneSeries& series, const Terms& terms) noexcept;

}  // namespace styled::gait
