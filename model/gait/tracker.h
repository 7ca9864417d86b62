#pragma once

#include <complex>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/gait/tuning.h"

namespace styled::gait {

// The place of one frame in a stride.
struct Phase {
  // 0: the left foot is farthest in front, about when its heel strikes; pi: the right one. It grows
  // by 2 pi per stride and is kept within 0 .. 2 pi.
  float phase_rad = 0;
  float rate_rad_s = tuning::kUsual_rad_s;  // 2 pi times the strides per second
  float confidence = 0;                     // 0 .. 1; 0 while the performer does not walk or run
  // The hips' height in step with cos(2 phase), canonical metres: above 0 in a run, whose hips are
  // highest while the feet are far apart; below 0 in a walk, whose hips are lowest then.
  float bounce_m = 0;

  // The phase `ahead_s` later at the same rate.
  STYLED_REALTIME float After(float ahead_s) const noexcept {
    return phase_rad + ahead_s * rate_rad_s;
  }
};

// 0: a walk, 1: a run, by the bounce and by the speed over the floor, m/s (0: on the spot).
STYLED_REALTIME float RunShare(const Phase& phase, float speed_mps) noexcept;

// Follows the phase of a gait, causally, frame by frame. The distance by which the left foot is in
// front of the right one is nearly a sine; a phase-locked loop of second order follows its analytic
// signal, so that a constant cadence has no lag. The confidence needs three things: a distance of
// some size that also moves, a locked loop, and steps ahead: the body moves where it faces, or on
// the spot the forward-moving foot is above the other.
//
// Locks within 1 s, releases within 0.5 s. Value type of fixed size, no allocation; one thread at a
// time. Mathematics: model/gait/README.md. Pinned by tests/unit/gait/tracker_test.cpp.
class Tracker {
 public:
  // Processes a frame, `dt_s` after the one before (0: the first; less
  // than 0.1 ms: left out). `heading_rad`: body::Heading_rad
  // of `world`. `velocity_mps`: of the hips over the floor, smoothed, world; 0 if unknown.
  STYLED_REALTIME void Follow(const body::WorldPose& world, float heading_rad,
                              const body::Vec3& velocity_mps, float dt_s) noexcept;

  const Phase& phase() const { return phase_; }
  // The same state with the phase set back by `s` seconds: the start of a second pass over a clip.
  Tracker Before(float s) const noexcept;

  STYLED_REALTIME void Reset() noexcept { *this = Tracker(); }
  // The following frames continue the same gait with left and right exchanged.
  STYLED_REALTIME void Mirror() noexcept;
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  float Ahead() const noexcept;
  float Target() const noexcept;

  Phase phase_;
  float distance_m_ = 0, mean_m_ = 0, speed_mps_ = 0;  // of the feet; the speed smoothed
  float amplitude_m_ = 0, square_speed_ = 0;           // means
  float lock_ = 0, lift_ = 0;                          // means
  float hips_m_ = 0;                                   // mean height
  Eigen::Vector2f heading_ = Eigen::Vector2f::Zero();  // its sine and cosine, mean
  Eigen::Vector2f way_mps_ = Eigen::Vector2f::Zero();  // velocity to the left and ahead, mean
  bool started_ = false;
};

}  // namespace styled::gait
