#pragma once

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/gait/curve.h"

namespace styled::phase {

// The effects of a style on a performer's movement over time, apart from its tables (design.h).
// Values of several styles add.
struct DynamicValues {
  float energy = 0;  // added to the gain of movements about their mean: 0, the performer's own
  float lag_s = 0, tremor_rad = 0, wander_rad = 0, hold_s = 0;

  bool any() const { return moves() || tremor_rad != 0 || wander_rad != 0; }
  bool moves() const { return energy != 0 || lag_s > 0 || hold_s > 0; }
};

// The state of one stream: means of the joints' rotations over a second, and the movement about
// them, delayed or held. Fixed size, no allocation; one thread at a time.
class Dynamics {
 public:
  // Adds to `turns` those of a step, `dt_s` after the one before, of the performer's own pose.
  // `time_s` of the step: what shakes and drifts is a function of it, so that all interleaved
  // streams of a performer do the same.
  STYLED_REALTIME void Follow(const gait::Rotations& own, const DynamicValues& values,
                              double time_s, float dt_s, gait::Vectors& turns) noexcept;
  STYLED_REALTIME void Reset() noexcept { active_ = false; }
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;  // see model/base/checkpoint.h

 private:
  void FollowMovement(const gait::Rotations& own, const DynamicValues& values, double time_s,
                      float dt_s, gait::Vectors& turns) noexcept;

  bool active_ = false;
  gait::Rotations mean_;
  gait::Vectors value_ = gait::Vectors::Zero(), rate_ = gait::Vectors::Zero();
  gait::Vectors frozen_ = gait::Vectors::Zero();
  double frozen_until_s_ = 0;
};

}  // namespace styled::phase
