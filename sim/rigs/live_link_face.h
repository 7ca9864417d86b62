#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// A phone with Live Link Face: 61 values a frame, the built-in performer's face. The motion is not
// used. One performer, whose name is the phone's. Quirks: "lost" (the camera sees no face for two
// of every ten seconds).
Result<std::unique_ptr<Rig>> MakeLiveLinkFace(const Options& options);

}  // namespace styled::rigs
