#pragma once

#include <Eigen/Core>
#include <array>

#include "model/body/pose.h"

// Keeps standing feet in place: a small offset between the foot of the blended motion and the place
// where it is held, accumulated while it stands and released while it swings.
namespace styled::synthetic {

struct FootState {
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();  // world x, z
  double yaw_rad = 0;
  // The motion's own foot one tick ago.
  Eigen::Vector2d toe_m = Eigen::Vector2d::Zero();
  double foot_yaw_rad = 0;
  bool started = false;
  // A small step that returns a standing foot to its place; `step` is its progress, 0 .. 1.
  bool stepping = false;
  double step = 0, step_yaw_rad = 0;
  Eigen::Vector2d step_offset_m = Eigen::Vector2d::Zero();
};

// Left, right.
struct FeetState {
  std::array<FootState, 2> feet;
  double lift_m = 0;        // lifts the whole body so that its feet meet the floor
  double lift_speed_m = 0;  // filter state
  double rested_s = 0;      // since both feet stand and neither steps
};

struct FeetInput {
  Eigen::Vector2d path_m;           // world x, z of the pose's origin
  std::array<double, 2> contact{};  // 0 .. 1, left and right
  double standing = 0;              // 0 .. 1; small steps begin only near 1
};

// Advances the offsets by `dt_s`. `world` is the motion's own pose, rotated to its heading but not
// moved to its place.
void AdvanceFeet(const FeetInput& input, const body::WorldPose& world, double dt_s,
                 FeetState& state) noexcept;

// Bends the legs of `pose` (the same pose as `world`) so that the feet are at their held places.
void ApplyFeet(const FeetInput& input, const FeetState& state, const body::WorldPose& world,
               body::Pose& pose) noexcept;

}  // namespace styled::synthetic
