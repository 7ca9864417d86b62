#pragma once

#include <cstdint>

#include "model/body/pose.h"
#include "model/synthetic/motion_tables.h"

// The parts of a synthetic motion as functions of phase and time. Pure, no allocation; any thread.
namespace styled::synthetic {

// 0 before 0, 1 after 1, C2 in between.
double SmootherStep(double x) noexcept;

// Adds `weight` times the series at `phase` (cycles, any number), with its harmonics scaled by
// `amplitude`.
template <std::size_t kSize>
void AddSeries(const std::array<std::array<float, kSize>, kChannelCount>& series, double phase,
               double weight, double amplitude, Channels& out) noexcept;

// The time of a gesture: seconds since its rise began, and since its fall began (< 0: not yet).
struct GestureTime {
  double since_rise_s = 0, since_fall_s = -1;
  double cycle = 0;  // cycles of the periodic part
};

// Adds `weight` times the gesture, mirrored for the right hand.
void AddGesture(const Gesture& gesture, bool right, const GestureTime& time, double weight,
                Channels& out) noexcept;

// 1 while the foot stands, 0 while it swings, C2 over the phase.
double Contact(const Gait& gait, double phase, bool right) noexcept;

// A slow random motion within about -1 .. 1: three sines of seeded frequencies around `around_hz`.
double Wander(std::uint64_t seed, double time_s, double around_hz) noexcept;

// Converts channels to a pose at the origin, rotated to `heading_rad`.
void ToPose(const Channels& channels, double heading_rad, body::Pose& pose) noexcept;

// Splitmix64: 64 well-mixed bits, and a number in [0, 1) from them.
std::uint64_t Mix(std::uint64_t value) noexcept;
double Unit(std::uint64_t value) noexcept;

}  // namespace styled::synthetic
