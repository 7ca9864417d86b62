#include "model/gait/lanes.h"

namespace styled::gait {
namespace {

using body::kJointCount;

constexpr float kTiny = 1e-9F;  // instead of smaller divisors: what they divide is no larger

using OfJoints = Eigen::Array<float, kJointCount, 1>;
// Every kStride-th number of an array.
template <int kStride>
auto Strided(const float* numbers) noexcept {
  return Eigen::Map<const OfJoints, Eigen::Unaligned, Eigen::InnerStride<kStride>>(numbers);
}
template <int kStride>
auto Strided(float* numbers) noexcept {
  return Eigen::Map<OfJoints, Eigen::Unaligned, Eigen::InnerStride<kStride>>(numbers);
}

Lane Padded(const auto& numbers, float padding) noexcept {
  Lane lane;
  lane.head<kJointCount>() = numbers;
  lane.tail<kLanes - kJointCount>() = padding;
  return lane;
}

Lane SinesOf(const TurnLanes& t) noexcept { return (t.x * t.x + t.y * t.y + t.z * t.z).sqrt(); }

// The angles of turns with these sines of half the angle: 4 atan(tan(angle / 4)). The arc tangent
// of 0 .. 1 is that of Abramowitz and Stegun 4.4.49, off by 2e-8.
Lane AnglesOf(const TurnLanes& turns, const Lane& sine) noexcept {
  const Lane norm = (sine * sine + turns.w * turns.w).sqrt();
  const Lane t = sine / (turns.w.abs() + norm).max(kTiny);
  const Lane s = t * t;
  Lane sum = 0.0028662257F * s - 0.0161657367F;
  for (const float term : {0.0429096138F, -0.0752896400F, 0.1065626393F, -0.1420889944F,
                           0.1999355085F, -0.3333314528F}) {
    sum = sum * s + term;
  }
  return 4.0F * (t + t * s * sum);
}

}  // namespace

TurnLanes operator*(const TurnLanes& a, const TurnLanes& b) noexcept {
  return {
      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,
      a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

// Eigen works on eight numbers at once only where an expression has no select().
TurnLanes ExpOf(const VectorLanes& v) noexcept {
  const Lane angle_rad = (v.x * v.x + v.y * v.y + v.z * v.z).sqrt();
  const Lane half_rad = 0.5F * angle_rad;
  const Lane sine = half_rad.sin();
  const Lane scale = sine / angle_rad.max(kTiny);
  return {scale * v.x, scale * v.y, scale * v.z, half_rad.cos()};
}

VectorLanes LogOf(const TurnLanes& t) noexcept {
  const Lane sine = SinesOf(t);
  Lane scale = AnglesOf(t, sine) / sine.max(kTiny);
  scale = (t.w < 0.0F).select(-scale, scale);
  return {scale * t.x, scale * t.y, scale * t.z};
}

Lane AnglesOf(const TurnLanes& t) noexcept { return AnglesOf(t, SinesOf(t)); }

VectorLanes ToLanes(const Vectors& vectors) noexcept {
  const float* const first = vectors.data();
  return {Padded(Strided<3>(first), 0), Padded(Strided<3>(first + 1), 0),
          Padded(Strided<3>(first + 2), 0)};
}

// Quaternions are stored as x, y, z, w.
TurnLanes ToLanes(const Rotations& rotations) noexcept {
  const float* const first = rotations[0].coeffs().data();
  return {Padded(Strided<4>(first), 0), Padded(Strided<4>(first + 1), 0),
          Padded(Strided<4>(first + 2), 0), Padded(Strided<4>(first + 3), 1)};
}

Vectors FromLanes(const VectorLanes& v) noexcept {
  Vectors vectors = Vectors::Zero();
  float* const first = vectors.data();
  Strided<3>(first) = v.x.head<kJointCount>();
  Strided<3>(first + 1) = v.y.head<kJointCount>();
  Strided<3>(first + 2) = v.z.head<kJointCount>();
  return vectors;
}

Rotations FromLanes(const TurnLanes& t) noexcept {
  const Lane share = (t.x * t.x + t.y * t.y + t.z * t.z + t.w * t.w).sqrt().inverse();
  Rotations rotations;
  float* const first = rotations[0].coeffs().data();
  Strided<4>(first) = (share * t.x).head<kJointCount>();
  Strided<4>(first + 1) = (share * t.y).head<kJointCount>();
  Strided<4>(first + 2) = (share * t.z).head<kJointCount>();
  Strided<4>(first + 3) = (share * t.w).head<kJointCount>();
  return rotations;
}

LaneSeries ToLanes(const Series& series) noexcept {
  LaneSeries lanes = LaneSeries::Zero();
  for (int joint = 0; joint < kJointCount; ++joint) {
    for (int axis = 0; axis < 3; ++axis) {
      lanes.row(kLanes * axis + joint) = series.row(3 * joint + axis);
    }
  }
  return lanes;
}

VectorLanes LanesAt(const LaneSeries& series, const Terms& terms) noexcept {
  const Eigen::Matrix<float, 3 * kLanes, 1> sum = series * terms;
  return {sum.segment<kLanes>(0), sum.segment<kLanes>(kLanes), sum.segment<kLanes>(2 * kLanes)};
}

}  // namespace styled::gait
