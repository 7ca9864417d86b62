#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// Qualisys Track Manager as a QTM RT server (TCP, little-endian), for at most ten clients. It
// greets, and answers Version, QTMVersion, ByteOrder, GetState, GetParameters (All, General, 3D,
// Skeleton), StreamFrames (AllFrames, Frequency:N, FrequencyDivisor:N; by TCP) and GetCurrentFrame,
// in any case of letters; all else with an error. One skeleton per performer: the canonical
// humanoid's proportions with the segments of QTM's own skeleton (a third spine, rolls of the
// forearms), whose frames are turned in the T-pose, so that rest rotations matter; millimetres, +Z
// up, facing -Y. Components: Skeleton, Timecode, and 3D, a marker at every joint. A NaN joint is
// sent as NaN. A restart is a new measurement: "no more data", the event, timestamps from the
// start.
//
// Quirks: "flat" (a QTM that speaks up to 1.20: segments are listed, not nested); "y-up"; "split"
// (packets come in pieces of a few bytes to a kilobyte); "timecode" (SMPTE, at 30 frames a second);
// "blink" (the skeletons are not seen, a tenth of the time); "full" (ten other clients are
// connected). Pinned by tests/e2e/rigs/qtm_test.cpp and tests/witness/qtm.
Result<std::unique_ptr<Rig>> MakeQtm(const Options& options);

}  // namespace styled::rigs
