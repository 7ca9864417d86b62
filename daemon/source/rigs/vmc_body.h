#pragma once

#include <array>

#include "model/rig/skeleton.h"
#include "proto/rigs/vmc/bones.h"

namespace styled::source {

// Where VMC's bones lie, relative to their parents, as received: Unity's axes, metres.
using BonePositions = std::array<std::array<float, 3>, vmc::kBoneCount>;

// Those that no binding can do without, or that move the body: what the canonical humanoid has.
vmc::BoneSet CanonicalBones();
// Those that every VRM has.
vmc::BoneSet RequiredBones();

// The body that these bones make, hips among them: right-handed, joints by vmc::kParentsFirst, rest
// rotations identity, as of VRM's normalized humanoid. Where all positions but the hips' are zero,
// which some senders leave so, the bones are as long as the canonical humanoid's.
rig::RigBody MakeVmcBody(vmc::BoneSet bones, const BonePositions& positions);

}  // namespace styled::source
