#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/rig/binding.h"

namespace styled::stylist {

// Stands in for the feet stage: how far up the styled body must be shifted for its lowest foot to
// be as high as the input's. "Lowest" is a soft minimum over feet and toes (1 cm wide), so that the
// shift has no kink where one foot takes over from the other.

// On the canonical humanoid, metres along +Y.
STYLED_REALTIME float GroundShift_m(const body::Pose& input, const body::Pose& styled) noexcept;

// On the source skeleton, in its units along its own up axis.
STYLED_REALTIME float GroundShift(const rig::Binding& binding, const rig::RigPose& input,
                                  const rig::RigPose& styled) noexcept;

// Moves the hips of `styled` by `shift` source units along the source's up axis.
STYLED_REALTIME void ShiftUp(const rig::Binding& binding, float shift,
                             rig::RigPose& styled) noexcept;

// A critically damped second-order low-pass: what it follows may jump, its own velocity does not.
class Glide {
 public:
  STYLED_REALTIME float Follow(float target, float dt_s, float tau_s) noexcept;
  STYLED_REALTIME void Rest() noexcept { *this = Glide(); }
  float value() const { return value_; }

 private:
  float value_ = 0, velocity_ = 0;
  bool started_ = false;
};

}  // namespace styled::stylist
