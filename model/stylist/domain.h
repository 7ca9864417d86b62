#pragma once

#include "model/base/checkpoint.h"
#include "model/base/critically_damped.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// Measures how far a pose is within the network's training domain. The in-domain weight, 1 inside
// and 0 outside, scales the style delta. Either of two causes reduces it: the network's
// reconstruction error, smoothed over Options::out_of_domain_fade_s; and the hips' tilt off
// upright, smoothed over no more than tuning::kTiltFade_s, because styles belong to upright bodies
// and would push a lying one through the floor. Value type, no allocation; one thread at a time.
// Pinned by tests/unit/stylist/domain_test.cpp.
class Domain {
 public:
  // Evaluates one frame by the network's `reconstruction_rad` (rms over joints) and the hips'
  // rotation relative to the world. `dt_s`: time since the frame before. `first`: there was none;
  // no smoothing.
  STYLED_REALTIME void Follow(float reconstruction_rad, const body::Quat& hips, float dt_s,
                              bool first, const Options& options) noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = Domain(); }

  float weight() const { return reconstruction_ * upright_; }
  // Whether some of the style is withheld.
  bool reduces() const { return reconstruction_ < 1.0F || upright_ < 1.0F; }
  // Whether most of the style is withheld: FLAG_OUT_OF_DOMAIN.
  bool outside() const { return reconstruction_ < 0.5F || upright_ < 0.5F; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept {
    c(fade_, tilt_fade_, reconstruction_, upright_);
  }

 private:
  CriticallyDamped fade_, tilt_fade_;
  float reconstruction_ = 1.0F, upright_ = 1.0F;
};

}  // namespace styled::stylist
