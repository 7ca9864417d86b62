#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// Rokoko Studio Live, layout 3: one datagram per frame for all actors, joints in the world and
// left-handed, each turned from the reference rotation that Studio's T-pose has there. What is not
// tracked is left out. At most 8 performers, 5 with "gloves" and without "lz4": a datagram's size.
// Quirks: "lz4" (packed), "gloves" (fingers, straight).
Result<std::unique_ptr<Rig>> MakeRokoko(const Options& options);

}  // namespace styled::rigs
