#pragma once

#include <Eigen/Core>
#include <array>

#include "model/body/pose.h"

// Feet that stay where they stand: small offsets between where the blended motion puts a foot and
// where it is held, gathered while it stands and given back while it swings.
namespace styled::synthetic {

struct FootState {
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();  // world x, z
  double yaw_rad = 0;
  // Of the motion's own foot, one tick ago.
  Eigen::Vector2d toe_m = Eigen::Vector2d::Zero();
  double foot_yaw_rad = 0;
  bool started = false;
  // A small step that puts a standing foot back: progress 0 .. 1 where stepping.
  bool stepping = false;
  double step = 0, step_yaw_rad = 0;
  Eigen::Vector2d step_offset_m = Eigen::Vector2d::Zero();
};

// Left, right.
struct FeetState {
  std::array<FootState, 2> feet;
  double lift_m = 0;        // of the whole body, onto the floor
  double lift_speed_m = 0;  // filter state
  double rested_s = 0;      // since the last small step
};

struct FeetInput {
  Eigen::Vector2d path_m;           // world x, z of the pose's origin
  std::array<double, 2> contact{};  // 0 .. 1, left and right
  double standing = 0;              // 0 .. 1: small steps are taken where it is about 1
};

// Advances the offsets by `dt_s`. `world` is the motion's own pose, turned but not moved to its
// place.
void AdvanceFeet(const FeetInput& input, const body::WorldPose& world, double dt_s,
                 FeetState& state) noexcept;

// Bends the legs of `pose` (as `world`, at its origin) so that the feet are where they are held.
void ApplyFeet(const FeetInput& input, const FeetState& state, const body::WorldPose& world,
               body::Pose& pose) noexcept;

}  // namespace styled::synthetic
