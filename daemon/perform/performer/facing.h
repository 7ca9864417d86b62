#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::pipeline {

// Detects that a performer walks against the direction of the toes for longer than people walk
// backwards, which means that the bound skeleton has left and right exchanged, or mirrored axes.
// Judges the bound input (canonical axes, metres); one per performer. Allocates nothing. Pinned by
// tests/unit/daemon/perform/performer/facing_test.cpp.
class Facing {
 public:
  // Evaluates one frame, `dt_s` of source time after the last. Ignores steps that are not walking:
  // slower than kSlow_mps (swaying), faster than kFast_mps (a jump of the rig), or sideways.
  STYLED_REALTIME void Sample(const body::Pose& pose, double dt_s) noexcept {
    body::Vec3 step = pose.hips_position_m - last_m_;
    last_m_ = pose.hips_position_m;
    if (!started_ || !(dt_s > 0)) {
      started_ = true;
      return;
    }
    step.y() = 0;
    const float length_m = step.norm();
    const auto dt = static_cast<float>(dt_s);
    if (!(length_m > kSlow_mps * dt && length_m < kFast_mps * dt)) return;
    body::Vec3 forward = Forward(pose);
    forward.y() = 0;
    if (forward.norm() < kUpright) return;  // lying or falling
    const float along = forward.normalized().dot(step) / length_m;
    if (std::abs(along) < kAlong) return;
    (along > 0 ? ahead_m_ : back_m_) += length_m;
    // Beyond this distance, earlier steps count half.
    if (ahead_m_ + back_m_ > kRemembered_m) {
      ahead_m_ /= 2;
      back_m_ /= 2;
    }
    if (backwards_ ? ahead_m_ > back_m_ : back_m_ > kSuspect_m && back_m_ > kOften * ahead_m_) {
      backwards_ = !backwards_;
    }
  }
  // Call when the rig starts a new session.
  STYLED_REALTIME void Reset() noexcept { *this = Facing(); }

  bool backwards() const { return backwards_; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(last_m_, ahead_m_, back_m_, started_, backwards_);
  }

 private:
  static constexpr float kSlow_mps = 0.3F, kFast_mps = 6.0F;
  static constexpr float kUpright = 0.5F;    // horizontal share of the forward axis
  static constexpr float kAlong = 0.7F;      // cosine: within 45 degrees of forward or backward
  static constexpr float kSuspect_m = 5.0F;  // distance backwards; an actor walks fewer steps
  static constexpr float kOften = 9.0F;      // nine of ten metres walked
  static constexpr float kRemembered_m = 20.0F;

  // The mean forward axis of both feet in the world. Joints that the source lacks have identity
  // rotations, so that without legs this is the axis of the hips.
  static body::Vec3 Forward(const body::Pose& pose) noexcept {
    body::Vec3 sum = body::Vec3::Zero();
    for (const auto& leg :
         {std::array{body::kLeftUpperLeg, body::kLeftLowerLeg, body::kLeftFoot},
          std::array{body::kRightUpperLeg, body::kRightLowerLeg, body::kRightFoot}}) {
      body::Quat world = pose.rotations[body::kHips];
      for (const body::Joint joint : leg) world = world * pose.rotations[joint];
      body::Vec3 foot = world * body::Vec3::UnitZ();
      foot.y() = 0;
      sum += foot;
    }
    return sum / 2;
  }

  body::Vec3 last_m_ = body::Vec3::Zero();
  float ahead_m_ = 0, back_m_ = 0;  // recent distances
  bool started_ = false, backwards_ = false;
};

}  // namespace styled::pipeline
