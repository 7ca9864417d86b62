#pragma once

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::gait {

// The velocity of a performer's hips over the floor, world, m/s, averaged over a step (0.2 s). The
// average reaches back at most to the session's start, so that a session that begins in mid-stride
// does not begin with the speed of standing. Value type; one thread at a time.
class Velocity {
 public:
  // Processes a frame, `dt_s` after the one before. A step that no performer makes is ignored.
  STYLED_REALTIME void Follow(const body::Vec3& hips_m, float dt_s) noexcept;

  const body::Vec3& mps() const { return mps_; }  // horizontal
  bool known() const { return seen_ > 0; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  body::Vec3 last_m_ = body::Vec3::Zero(), mps_ = body::Vec3::Zero();
  float seen_ = 0;  // 0 .. 1: the share of the average that has been filled
  bool placed_ = false;
};

}  // namespace styled::gait
