#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// A phone with iFacialMocap: it waits for the start text and then sends the built-in performer's
// face to its sender. The motion is not used. One performer. Quirks: "v1" (version 1 of the text,
// whatever was requested), "state" (a part with the tracking's state precedes the others, as in
// newer apps).
Result<std::unique_ptr<Rig>> MakeIFacialMocap(const Options& options);

}  // namespace styled::rigs
