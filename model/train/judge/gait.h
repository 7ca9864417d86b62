#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "model/body/pose.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {

// How a body walks or runs, as pure functions of poses (metres, y up, constant rate). Pinned by
// tests/unit/judge/gait_test.cpp.

// One clip's figure each; a mean over clips after Add. A figure without a count was not measured.
// A step is the time between two moments at which one foot passes the other, along the heading.
struct Gait {
  Mean speed_cm_s;       // of the hips over the floor
  Mean cadence_per_min;  // steps
  Mean step_cm;          // the largest distance of the ankles along the heading, mean over steps
  Mean bob_cm;           // rise and fall of the hips within two steps
  Mean lowest_knee_deg;  // least bend of each knee, 0 is straight; mean over the two
  Mean mean_knee_deg;    // over time
  Mean arm_swing_cm;     // range of a hand along the heading from the hips, within two steps

  void Add(const Gait& clip);
};

// The figures of one clip. Cadence, step, bob and arm swing need three passings of the feet, the
// speed a second.
Gait MeasureGait(std::span<const body::Pose> poses, double rate_hz);

struct GaitColumn {
  std::string_view key, title;
  Mean Gait::*figure;
  int decimals;
};
inline constexpr std::array<GaitColumn, 7> kGaitColumns{{
    {"speed_cm_s", "speed cm/s", &Gait::speed_cm_s, 0},
    {"cadence_per_min", "steps/min", &Gait::cadence_per_min, 0},
    {"step_cm", "step cm", &Gait::step_cm, 0},
    {"bob_cm", "bob cm", &Gait::bob_cm, 1},
    {"lowest_knee_deg", "least knee deg", &Gait::lowest_knee_deg, 1},
    {"mean_knee_deg", "mean knee deg", &Gait::mean_knee_deg, 0},
    {"arm_swing_cm", "arm swing cm", &Gait::arm_swing_cm, 0},
}};

// The bend of a knee, degrees, 0 is straight: the angle between thigh and shank.
float KneeBend_deg(const body::WorldPose& world, int upper_leg);

// The heading per frame as a unit vector on the floor, averaged over half a second around it.
std::vector<body::Vec3> SmoothHeadings(std::span<const body::WorldPose> worlds, double rate_hz);

}  // namespace styled::judge
