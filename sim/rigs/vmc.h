#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// VirtualMotionCapture's sender, or another program's by quirk. One performer on an avatar with the
// canonical humanoid's proportions; joints that are not tracked are omitted. Like the application,
// it sends the bones in the order of HumanBodyBones, 13 per datagram; then a datagram of
// expressions; last a datagram with the root (fourteen arguments, for mixed reality), the remaining
// bones in a nested bundle, OK, and T, the seconds since its start.
// Quirks:
//   "t-first"       one datagram, T first, w < 0 where a bone is at rest, as SlimeVR
//   "nested"        the same with root and bones in bundles within one another
//   "single"        a datagram per message, T last
//   "full"          all 55 bones: upper chest, eyes, jaw and fingers at rest
//   "vrm1"          names as VRM 1.0 has them
//   "moving-root"   the avatar is carried and turned by its root, not by its hips
//   "zero-offsets"  all positions but the hips' and root's are zero
//   "no-t"          no T at all
//   "hands"         hands and fingers alone, as an assistant that tracks hands: the hands'
//                   rotations are those in the room, and all fingers but the thumbs close and open,
//                   each joint by HandsBend_rad
//   "trackers"      devices instead of bones, with other quirks: vmc_trackers.h
Result<std::unique_ptr<Rig>> MakeVmc(const Options& options);

// The bend of each finger joint of the quirk "hands", radians.
double HandsBend_rad(double time_s);

}  // namespace styled::rigs
