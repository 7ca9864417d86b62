#pragma once

#include <string>

#include "sim/rigs/rig.h"

namespace styled::rigs {

// SlimeVR's trackers over UDP: one board (MAC 025356 and the seed's last 24 bits). By default its
// sensors 0, 1, ... are on hips, chest, head, upper and lower arms, upper and lower legs and feet.
// Quirks "hips", "leftFoot", ... select sensors, in that order. Several boards are several rigs,
// each with its own seed and socket and, if played that way, its own timing. Each sensor has a
// random heading and tilt; its mounting direction is the usual one (rig::Trackers::Facing).
//
// The board searches for a server once per second, starts when the server replies, and gives up
// after 3 s of silence. It announces its sensors until that is acknowledged, asks for the server's
// features, and sends bundles if the server allows it. Its performer first stands in a T-pose for a
// second, and the board with the hips sensor requests a full reset; then half a second in a ski
// pose, and it requests a mounting reset. Further quirks: "anyhow" (sensors mounted in any
// orientation), "unplaced" (the board does not announce where its sensors are), "no-reset" (the
// performer moves at once), "compact" (Q15 rotations in compact bundles), "legacy" (old firmware:
// rotation 1, nothing announced, one sensor).
Result<std::unique_ptr<Rig>> MakeSlimeVr(const Options& options);

// The daemon's configuration key for a sensor of the board: "025356000001/2".
std::string SlimeVrTrackerId(std::uint64_t seed, std::size_t sensor);

}  // namespace styled::rigs
