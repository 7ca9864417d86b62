#pragma once

#include "sim/rigs/rig.h"

namespace styled::rigs {

// VirtualMotionCapture's sender, or another's by quirk. One performer on an avatar of the canonical
// humanoid's measures; what is not tracked is left out. As the application itself sends: bones in
// the order of HumanBodyBones, 13 to a datagram; then a datagram of expressions; last one with the
// root (of fourteen arguments, for mixed reality), the rest of the bones in a bundle within, OK
// and T, its seconds since it was started.
// Quirks:
//   "t-first"       one datagram, T first, w < 0 where a bone is at rest, as SlimeVR
//   "nested"        the same with root and bones in bundles within one another
//   "single"        a datagram per message, T last
//   "full"          all 55 bones: upper chest, eyes, jaw and fingers at rest
//   "vrm1"          names as VRM 1.0 has them
//   "moving-root"   the avatar is carried and turned by its root, not by its hips
//   "zero-offsets"  all positions but the hips' and root's are zero
//   "no-t"          no T at all
Result<std::unique_ptr<Rig>> MakeVmc(const Options& options);

}  // namespace styled::rigs
