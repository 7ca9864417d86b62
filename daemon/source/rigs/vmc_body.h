#pragma once

#include <array>
#include <string>

#include "model/rig/skeleton.h"
#include "proto/rigs/vmc/bones.h"

namespace styled::source {

// Positions of VMC's bones relative to their parents, as received: Unity's axes, metres.
using BonePositions = std::array<std::array<float, 3>, vmc::kBoneCount>;

// The bones of the canonical humanoid: those that a binding requires or that move the body.
vmc::BoneSet CanonicalBones();
// The bones that every VRM model has.
vmc::BoneSet RequiredBones();

// The bones without which a body cannot be bound (rig::BindDialect), unless other joints are named
// in their place by hand.
vmc::BoneSet BindableBones();

// Why no performer can be made of a sender of `bones`, which lack some of BindableBones(): "VMC
// sends no leg bones: found Head, ..., missing Hips, ..., expected ...". Allocates.
std::string WhyNoPerformer(vmc::BoneSet bones);

// The body made of `bones`, at least one: right-handed, joints in the order of
// vmc::kParentsFirst, identity rest rotations as in VRM's normalized humanoid. If all positions but
// the hips' are zero, as some senders leave them, the bones get the canonical humanoid's lengths.
// Without hips, bones hang from the first one: such a body is only sent to be refused.
rig::RigBody MakeVmcBody(vmc::BoneSet bones, const BonePositions& positions);

}  // namespace styled::source
