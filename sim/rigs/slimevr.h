#pragma once

#include <string>

#include "sim/rigs/rig.h"

namespace styled::rigs {

// SlimeVR's trackers over UDP: one board (MAC 025356 and the seed's last 24 bits) whose sensors 0,
// 1, ... are worn on hips, chest, head, upper and lower arms, upper and lower legs and feet; or, by
// quirks "hips", "leftFoot", ..., on these alone, in that order: several boards are several rigs,
// each with a seed, a socket and, where they are so played, a rhythm of its own. Each sensor has a
// heading of its own, points as such sensors usually do (rig::Trackers::Facing) and is tilted at
// random.
//
// The board seeks a server once a second, begins when it is greeted, gives up after 3 s of silence;
// it announces its sensors until that is acknowledged, asks for features and bundles when it may.
// Its performer first stands in a T-pose for a second, and the board that sits on the hips asks for
// a full reset; then half a second like a skier, and it asks for a mounting reset.
// Further quirks: "anyhow" (sensors strapped on in any way at all), "unplaced" (the board does not
// tell where its sensors are worn), "no-reset" (the performer plays at once), "compact" (Q15
// rotations in compact bundles), "legacy" (as old firmware: rotation 1, nothing announced; one
// sensor).
Result<std::unique_ptr<Rig>> MakeSlimeVr(const Options& options);

// How the daemon's configuration calls a sensor of the board: "025356000001/2".
std::string SlimeVrTrackerId(std::uint64_t seed, std::size_t sensor);

}  // namespace styled::rigs
