#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// Sony mocopi's phone application: `skdf` at the start and every 3.5 s, `fram` for every frame,
// numbered from 1. One performer, whose body has the canonical humanoid's measures, cut into
// mocopi's seven pieces of back and two of neck, which share in the bends of the joints that the
// humanoid has. Quaternions have w <= 0, identity is -0, 0, -0, -1, as of the real one.
// Quirks: "tmcd" (1605 bytes instead of 1591), "early" (no `uttm`, as in early 2023).
Result<std::unique_ptr<Rig>> MakeMocopi(const Options& options);

}  // namespace styled::rigs
