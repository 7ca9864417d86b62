#pragma once

namespace styled::net {

// How badly a network may reconstruct a limb that it still knows: the limb gate
// (model/stylist/limb_gate.h) withholds the style of others. Each network has its own, since one
// that was taught more acts is off by more in a wave and by less in a kick. Distances are those of
// stylist::LimbErrors_m, mean of a limb's joints, canonical metres. The defaults are those of v1
// and of files without the key; how they and v2's were picked: model/stylist/tuning.h.
struct GateBounds {
  struct Range {
    float begin_m, end_m;  // where the style begins to fade out, and where it is gone
    friend bool operator==(const Range&, const Range&) = default;
  };
  Range arms{0.14F, 0.28F}, trunk{0.10F, 0.22F}, legs{0.12F, 0.26F};
  friend bool operator==(const GateBounds&, const GateBounds&) = default;
};

}  // namespace styled::net
