#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// OptiTrack's Motive as a NatNet server: answers CONNECT and DISCOVERY, echoes, questions for the
// model and the frame rate, and streams a skeleton for each performer, of Motive's 21 bones, with
// the canonical humanoid's measures, +Y up and in global coordinates, to everyone who was heard;
// the first frame says that the model changed. A joint of NaN is a bone marked as not tracked.
// Quirks: "2.9", "4.1", "4.2" (bitstream, instead of 3.0); "local" (bones relative to their
// parents); "z-up"; "prefix" (bones carry the skeleton's name, the hips nothing but it);
// "multicast" or "multicast=GROUP[:PORT][@INTERFACE]" (frames go to a group, by default
// 239.255.42.99:1511, from a socket of their own that faults do not reach; INTERFACE is an IPv4
// address of this machine).
Result<std::unique_ptr<Rig>> MakeNatNet(const Options& options);

}  // namespace styled::rigs
