#pragma once

#include <memory>
#include <string>

#include "sim/rigs/rig.h"

namespace styled::rigs {

// The serial of the device on that joint: "HMD-0", "LHR-hips", ...
std::string VmcSerial(body::Joint joint);

// An assistant that sends VMC's devices and no bones: a display, two controllers, and trackers on
// hips, chest, feet, upper legs and upper arms, in one bundle with T last. Used by `stylesim --as
// vmc --quirk trackers` (vmc.h). Quirks: those of WornDevices (worn_devices.h), and
//   single  each message in a datagram of its own
//   local   also the raw poses (/Local), which have no effect here, and a button (/VMC/Ext/Con)
Result<std::unique_ptr<Rig>> MakeVmcTrackers(const Options& options);

}  // namespace styled::rigs
