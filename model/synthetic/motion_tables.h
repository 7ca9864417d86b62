#pragma once

#include <array>
#include <span>

#include "model/body/humanoid.h"

// The data of the synthetic performer. A motion is a function from time to channels: per joint
// (body::Joint order) the rotation vector of its local rotation (rad; the hips' relative to the
// heading), then the hips' position relative to the path: sideways (to the left), height and
// forward (m). In these coordinates the T-pose is 0, and poses can be added and blended.
namespace styled::synthetic {

inline constexpr int kSideways = 3 * body::kJointCount;
inline constexpr int kHeight = kSideways + 1;
inline constexpr int kForward = kSideways + 2;
inline constexpr int kChannelCount = kSideways + 3;
using Channels = std::array<float, kChannelCount>;

// A truncated Fourier series over the gait's phase (0 .. 1): the mean, then cosine and sine of each
// harmonic. At phase 0 the left foot passes the right one.
template <int kOrder>
using Series = std::array<float, 2 * kOrder + 1>;
inline constexpr int kGaitOrder = 5;
inline constexpr int kTurnOrder = 2;

extern const Channels kStand;
extern const std::array<Series<kGaitOrder>, kChannelCount> kWalk;
extern const std::array<Series<kTurnOrder>, kChannelCount> kWalkTurn;  // per rad/s to the left
extern const std::array<Series<kGaitOrder>, kChannelCount> kRun;

// One channel of a gesture, relative to standing: a uniform cubic B-spline with a knot every
// kKnot_s, from 0 to the plateau and back to 0, plus a periodic part on the plateau (cosine and
// sine of three harmonics). The spline's end coefficients (0, and the plateau = the last of `rise`)
// are used three times.
struct GestureRow {
  int channel;
  std::array<float, 5> rise;
  std::array<float, 5> fall;
  std::array<float, 6> cycle;
};
inline constexpr double kKnot_s = 0.125;
inline constexpr int kRiseKnots = 7, kFallKnots = 8;
inline constexpr double kRise_s = kRiseKnots * kKnot_s, kFall_s = kFallKnots * kKnot_s;

struct Gesture {
  std::span<const GestureRow> rows;
  double cycle_hz;
};

extern const Gesture kRaiseOne, kWaveOne;  // of the left hand
extern const Gesture kRaiseBoth, kWaveBoth;

// Length of a gait cycle (m), cycles per second, and the phases of the left foot's contact with the
// width of its blurred edges. The right foot's contact is half a cycle later.
struct Gait {
  double stride_m, cycles_hz;
  double land, lift, blur;
};
inline constexpr Gait kWalkGait{1.366, 0.909, 0.25, 0.68, 0.07};
inline constexpr Gait kRunGait{2.363, 1.304, 0.36, 0.50, 0.055};
// A walking turn of w rad/s shortens the stride (m) and drifts sideways (m/s), each per rad/s.
inline constexpr double kTurnShortens_m = 0.23;
inline constexpr double kTurnDrift_m = -0.175;
// Straight walking drifts a little to the left of the heading, m/s.
inline constexpr double kWalkDrift_m = 0.054;
// The height of the toe joint above the floor while the foot stands, m.
inline constexpr double kToeHeight_m = 0.045;

}  // namespace styled::synthetic
