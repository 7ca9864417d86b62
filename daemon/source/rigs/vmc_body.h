#pragma once

#include <array>

#include "model/rig/skeleton.h"
#include "proto/rigs/vmc/bones.h"

namespace styled::source {

// Positions of VMC's bones relative to their parents, as received: Unity's axes, metres.
using BonePositions = std::array<std::array<float, 3>, vmc::kBoneCount>;

// The bones of the canonical humanoid: those that a binding requires or that move the body.
vmc::BoneSet CanonicalBones();
// The bones that every VRM model has.
vmc::BoneSet RequiredBones();

// The body made of `bones`, which must include the hips: right-handed, joints in the order of
// vmc::kParentsFirst, identity rest rotations as in VRM's normalized humanoid. If all positions but
// the hips' are zero, as some senders leave them, the bones get the canonical humanoid's lengths.
rig::RigBody MakeVmcBody(vmc::BoneSet bones, const BonePositions& positions);

}  // namespace styled::source
