#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// Rokoko Studio Live, layout 3. One datagram per frame for all actors; joints are global and
// left-handed, rotated relative to the reference rotation of Studio's T-pose. Joints that are not
// tracked are omitted. At most 8 performers, or 5 with "gloves" and without "lz4", limited by a
// datagram's size. Props are the scene's. Quirks: "lz4" (compressed), "gloves" (with fingers,
// straight), "face" (with the face of the built-in performer).
Result<std::unique_ptr<Rig>> MakeRokoko(const Options& options);

}  // namespace styled::rigs
