#pragma once

namespace styled::net {

// The reconstruction errors of a limb between which the limb gate (model/stylist/limb_gate.h)
// withholds its style. Each network has its own bounds, because one that learned more acts has
// larger errors in a wave and smaller ones in a kick. Distances are those of stylist::LimbErrors_m,
// mean of a limb's joints, canonical metres. The defaults are those of v1 and of files without the
// key; how they and v2's were picked: model/stylist/tuning.h.
struct GateBounds {
  struct Range {
    float begin_m, end_m;  // distances at which the style begins to fade out, and is gone
    friend bool operator==(const Range&, const Range&) = default;
  };
  Range arms{0.14F, 0.28F}, trunk{0.10F, 0.22F}, legs{0.12F, 0.26F};
  friend bool operator==(const GateBounds&, const GateBounds&) = default;
};

}  // namespace styled::net
