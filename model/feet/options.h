#pragma once

#include "model/feet/tuning.h"

namespace styled::feet {

// Settings of the feet stage, the same for all performers. Lengths are canonical metres (a source
// skeleton is scaled by its hips height), times seconds. The defaults are those of styled.toml;
// model/feet/tuning.h has their sources.
struct Options {
  // A heel or toe is in contact while it is low (height above its planted height, 0 .. 1) and slow
  // (speed over the ground, 0 .. 20). Between the two bounds of each pair the weight falls smoothly
  // from 1 to 0.
  float contact_low_m = tuning::kContactLow_m, contact_high_m = tuning::kContactHigh_m;
  float contact_slow_mps = tuning::kContactSlow_mps, contact_fast_mps = tuning::kContactFast_mps;
  // Time constants of a contact's beginning and end; 0 .. 1.
  float blend_in_s = tuning::kBlendIn_s, blend_out_s = tuning::kBlendOut_s;
  // The distance from the styled foot at which a lock has fully released; 0.001 .. 1.
  float reach_m = tuning::kReach_m;
  // Time constant of the return to the styled foot; 0.001 .. 10.
  float return_s = tuning::kReturn_s;
  // A step lands at an offset from its styled place such that it ends with the opposite offset.
  // `centre_s`: the time constant of the gait's mean that this needs, 0.01 .. 60. `centre`: the
  // share of the offset, 0 (lands as styled) .. 1.
  float centre_s = tuning::kCentre_s;
  float centre = tuning::kCentre;
  // The hips come down if a leg must reach farther than this share of its length; 0.5 .. 1.
  float stretch = tuning::kStretch;
  // The most that the hips come down, 0 .. 1, and the time constant of it, 0 .. 10.
  float hips_drop_m = tuning::kHipsDrop_m;
  float hips_tau_s = tuning::kHipsTau_s;

  friend bool operator==(const Options&, const Options&) = default;
};

// Whether all are in their ranges; NaN is in none.
[[nodiscard]] constexpr bool IsValid(const Options& o) {
  const auto in = [](float value, float low, float high) { return value >= low && value <= high; };
  return in(o.contact_low_m, 0, 1) && in(o.contact_high_m, 0, 1) &&
         o.contact_low_m < o.contact_high_m && in(o.contact_slow_mps, 0, 20) &&
         in(o.contact_fast_mps, 0, 20) && o.contact_slow_mps < o.contact_fast_mps &&
         in(o.blend_in_s, 0, 1) && in(o.blend_out_s, 0, 1) && in(o.reach_m, 1e-3F, 1) &&
         in(o.return_s, 1e-3F, 10) && in(o.centre_s, 0.01F, 60) && in(o.centre, 0, 1) &&
         in(o.stretch, 0.5F, 1) && in(o.hips_drop_m, 0, 1) && in(o.hips_tau_s, 0, 10);
}

}  // namespace styled::feet
