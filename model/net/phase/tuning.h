#pragma once

#include <array>

// The constants of the phase family (stylizer.h): value, unit, the trade-off of a larger value, and
// the figure that picked it.
namespace styled::phase::tuning {

// Angle of an upper or a lower arm (leg) from the neutral's mean, beyond kSpreads times its spread
// in a gait, between which the limb does something of its own, rad. The style then leaves it. In
// set 2's gestures, styles of a walk and a run, hands reach 0.97 as far, 8 degrees off; between 0.6
// and 1.3 rad 0.94 and 9, and the movement of runs is recognized a little more often (0.55 of them,
// not 0.53).
inline constexpr float kOwnBegin_rad = 0.4F, kOwnEnd_rad = 1.0F, kSpreads = 1.5F;
// Time constants with which a limb's share falls and rises, s, and of a second smoothing of both.
inline constexpr float kFall_s = 0.05F, kRise_s = 0.5F, kSmooth_s = 0.05F;
// The least share of an arm.
inline constexpr float kLeastArm = 0.1F;

// Time constant of the mean about which a style changes the size of movements, s.
inline constexpr float kMovementMean_s = 1.0F;
// The shortest lag, s: the spring's steps would not be stable below. And the time constant with
// which a held limb catches up, s.
inline constexpr float kLeastLag_s = 0.02F, kSnap_s = 0.04F;
// Frequencies of a tremor and of drifting, Hz. A tremor is as slow as the stylist's low-pass
// allows, which leaves a third of it.
inline constexpr std::array kTremor_hz{4.1, 4.9, 5.7, 6.3};
inline constexpr std::array kWander_hz{0.11, 0.19, 0.31};
inline constexpr float kThroughLowPass = 3.0F, kHeadShakes = 0.4F;

}  // namespace styled::phase::tuning
