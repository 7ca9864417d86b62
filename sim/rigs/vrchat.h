#pragma once

#include <memory>

#include "sim/rigs/rig.h"

namespace styled::rigs {

// A sender of OSC trackers for VRChat, like SlimeVR's server: head, and trackers 1 hips, 2 and 3
// feet, 4 and 5 upper legs, 6 chest, 7 and 8 upper arms, in one bundle per frame; the head's
// rotation once per session. Quirks: those of WornDevices (worn_devices.h), and
//   single    each message in a datagram of its own
//   vrsystem  also head and wrists, as VRChat sends them, instead of the head's tracker
Result<std::unique_ptr<Rig>> MakeVrChat(const Options& options);

}  // namespace styled::rigs
