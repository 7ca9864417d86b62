#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// Xsens MVN. It sends type 02 for each character and frame, and types 12 and 13 at the start and
// once per second. 23 segments: L3 and T12 lie between the canonical spine and chest and do not
// rotate relative to them. Props are the first character's, up to four. Quirks: "euler" (type 01
// instead of 02: centimetres, +Y up, degrees), "split" (each pose in two datagrams), "old" (payload
// size and segment counts are 0, as in old versions), "timecode" (type 25 before every pose).
Result<std::unique_ptr<Rig>> MakeMvn(const Options& options);

}  // namespace styled::rigs
