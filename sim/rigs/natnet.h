#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// OptiTrack's Motive as a NatNet server. It answers CONNECT, DISCOVERY, echo requests, and requests
// for the model and the frame rate. It streams to every client heard from: one skeleton per
// performer with Motive's 21 bones and the canonical humanoid's proportions, +Y up, in global
// coordinates. The first frame has the flag for a changed model. A NaN joint is sent as a bone that
// is not tracked. Props are rigid bodies, with the ids 101,
// 102, ... Quirks: "2.9", "4.1", "4.2" (bitstream version, instead of 3.0); "local" (bones
// relative to their parents); "z-up"; "prefix" (bone names start with the skeleton's name, and the
// hips have that name only); "multicast" or "multicast=GROUP[:PORT][@INTERFACE]" (frames go to a
// group, by default 239.255.42.99:1511, from a separate socket without faults; INTERFACE is an IPv4
// address of this machine).
Result<std::unique_ptr<Rig>> MakeNatNet(const Options& options);

}  // namespace styled::rigs
