#include "model/stylist/domain.h"

#include <algorithm>
#include <cmath>

#include "model/base/smooth.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {
namespace {

constexpr float kLeastSpan_rad = 1e-3F;  // shortest span of a fade

// 1 below `begin`, 0 above `end`.
float Inside(float value_rad, float begin_rad, float end_rad) {
  return 1.0F - SmoothStep((value_rad - begin_rad) / std::max(kLeastSpan_rad, end_rad - begin_rad));
}

}  // namespace

void Domain::Follow(float reconstruction_rad, const body::Quat& hips, float dt_s, bool first,
                    const Options& options) noexcept {
  const float inside =
      Inside(reconstruction_rad, options.out_of_domain_begin_rad, options.out_of_domain_end_rad);
  // A second-order filter of time constant tau delays by 2 tau.
  reconstruction_ = first ? fade_.Follow(inside, 0, 0)
                          : fade_.Follow(inside, dt_s, options.out_of_domain_fade_s / 2);
  const float up = (hips * body::Vec3::UnitY()).y();
  const float tilt_rad = std::acos(std::clamp(up, -1.0F, 1.0F));
  const float stands = Inside(tilt_rad, options.tilt_begin_rad, options.tilt_end_rad);
  upright_ =
      std::clamp(tilt_fade_.Follow(stands, dt_s, first ? 0 : tuning::kTiltFade_s), 0.0F, 1.0F);
}

}  // namespace styled::stylist
