#include "model/synthetic/synthesis.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/body/heading.h"

namespace styled::synthetic {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// A uniform cubic B-spline over `length` intervals, evaluated at `knots` (clamped to 0 .. length).
template <typename Coefficient>
double Spline(const Coefficient& coefficient, int length, double knots) noexcept {
  const double at = std::clamp(knots, 0.0, static_cast<double>(length));
  const int first = std::min(length - 1, static_cast<int>(at));
  const double f = at - first, g = 1 - f;
  return (g * g * g * coefficient(first) +
          (3 * f * f * f - 6 * f * f + 4) * coefficient(first + 1) +
          (3 * g * g * g - 6 * g * g + 4) * coefficient(first + 2) +
          f * f * f * coefficient(first + 3)) /
         6;
}

// The channel that corresponds to this one when left and right are swapped, and its sign.
struct Mirrored {
  int channel;
  double sign;
};
Mirrored MirrorChannel(int channel) noexcept {
  if (channel >= kSideways) return {channel, channel == kSideways ? -1.0 : 1.0};
  const int axis = channel % 3;
  return {3 * body::MirrorJoint(channel / 3) + axis, axis == 0 ? 1.0 : -1.0};
}

}  // namespace

double SmootherStep(double x) noexcept {
  const double s = std::clamp(x, 0.0, 1.0);
  return s * s * s * (10 + s * (6 * s - 15));
}

template <std::size_t kSize>
void AddSeries(const std::array<std::array<float, kSize>, kChannelCount>& series, double phase,
               double weight, double amplitude, Channels& out) noexcept {
  std::array<float, kSize> basis;
  basis[0] = static_cast<float>(weight);
  for (std::size_t k = 1; 2 * k < kSize; ++k) {
    const double angle = kTurn * static_cast<double>(k) * phase;
    basis[2 * k - 1] = static_cast<float>(weight * amplitude * std::cos(angle));
    basis[2 * k] = static_cast<float>(weight * amplitude * std::sin(angle));
  }
  for (int channel = 0; channel < kChannelCount; ++channel) {
    float sum = 0;
    for (std::size_t i = 0; i < kSize; ++i) sum += basis[i] * series[channel][i];
    out[channel] += sum;
  }
}
template void AddSeries(const std::array<Series<kGaitOrder>, kChannelCount>&, double, double,
                        double, Channels&) noexcept;
template void AddSeries(const std::array<Series<kTurnOrder>, kChannelCount>&, double, double,
                        double, Channels&) noexcept;

void AddGesture(const Gesture& gesture, bool right, const GestureTime& time, double weight,
                Channels& out) noexcept {
  const bool falling = time.since_fall_s >= 0;
  const double knots = (falling ? time.since_fall_s : time.since_rise_s) / kKnot_s;
  // The periodic part fades in as the plateau is reached and fades out as the hand begins to fall.
  double periodic = 0;
  if (gesture.cycle_hz > 0) {
    periodic = SmootherStep((time.since_rise_s - 0.7 * kRise_s) / 0.4);
    if (falling) periodic *= 1 - SmootherStep(time.since_fall_s / 0.35);
  }
  std::array<double, 6> basis;
  for (int k = 1; k <= 3; ++k) {
    basis[2 * k - 2] = periodic * std::cos(kTurn * k * time.cycle);
    basis[2 * k - 1] = periodic * std::sin(kTurn * k * time.cycle);
  }
  for (const GestureRow& row : gesture.rows) {
    const auto rise = [&row](int i) { return i < 3 ? 0.0F : row.rise[std::min(i - 3, 4)]; };
    const auto fall = [&row](int i) {
      return i < 3 ? row.rise[4] : i < 8 ? row.fall[i - 3] : 0.0F;
    };
    double value = falling ? Spline(fall, kFallKnots, knots) : Spline(rise, kRiseKnots, knots);
    for (int i = 0; i < 6; ++i) value += basis[i] * row.cycle[i];
    const Mirrored to = right ? MirrorChannel(row.channel) : Mirrored{row.channel, 1.0};
    out[to.channel] += static_cast<float>(weight * to.sign * value);
  }
}

double Contact(const Gait& gait, double phase, bool right) noexcept {
  const double shifted = phase + (right ? 0.5 : 0.0);
  const double p = shifted - std::floor(shifted);
  return SmootherStep((p - gait.land) / gait.blur) *
         (1 - SmootherStep((p - gait.lift) / gait.blur));
}

double Wander(std::uint64_t seed, double time_s, double around_hz) noexcept {
  double sum = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const double hz =
        around_hz * (0.6 + 0.35 * static_cast<double>(i) + 0.25 * Unit(seed * 6 + 2 * i));
    sum += std::sin(kTurn * (hz * time_s + Unit(seed * 6 + 2 * i + 1)));
  }
  return sum / 2;
}

void ToPose(const Channels& channels, double heading_rad, body::Pose& pose) noexcept {
  const body::Quat turn = body::Yaw(static_cast<float>(heading_rad));
  for (int joint = 0; joint < body::kJointCount; ++joint) {
    pose.rotations[joint] = body::Exp(
        body::Vec3(channels[3 * joint], channels[3 * joint + 1], channels[3 * joint + 2]));
  }
  pose.rotations[body::kHips] = (turn * pose.rotations[body::kHips]).normalized();
  pose.hips_position_m =
      turn * body::Vec3(channels[kSideways], channels[kHeight], channels[kForward]);
}

std::uint64_t Mix(std::uint64_t value) noexcept {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31);
}

double Unit(std::uint64_t value) noexcept {
  return static_cast<double>(Mix(value) >> 11) * 0x1p-53;
}

}  // namespace styled::synthetic
