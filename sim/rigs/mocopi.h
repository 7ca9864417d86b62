#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// Sony mocopi's phone application. It sends `skdf` at the start and every 3.5 s, and `fram` for
// each frame, numbered from 1. One performer; the body has the canonical humanoid's proportions.
// mocopi has seven spine and two neck joints, which share the bends of the humanoid's joints.
// Quaternions have w <= 0, and identity is -0, 0, -0, -1, as in recordings of the real application.
// Quirks: "tmcd" (1605 bytes instead of 1591), "early" (no `uttm`, as in early 2023).
Result<std::unique_ptr<Rig>> MakeMocopi(const Options& options);

}  // namespace styled::rigs
