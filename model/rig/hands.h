#pragma once

#include <bitset>
#include <vector>

#include "model/base/status.h"
#include "model/rig/binding.h"
#include "model/rig/dialects.h"
#include "model/rig/tail.h"

// Hands without the rest of a body, and bodies without fingers: puts the fingers of one rig
// (gloves) on the hands of another. Everything here allocates; any thread. Pinned by
// tests/unit/rig/hands_test.cpp.
namespace styled::rig {

// Joints of the tail, by TailJoint.
using TailSet = std::bitset<kTailCount>;

// The 15 finger joints of the left hand, or of the right one.
TailSet FingersOf(body::Joint hand);

// The position of a finger joint in its parent's frame (the joint before it, or the hand) in the
// T-pose, on hands of the canonical humanoid's size; canonical axes, metres. The lengths are those
// of an adult's hand.
Vec3 FingerOffset_m(int joint);

// The binding with the joints of `wanted` (fingers) that its skeleton lacks, appended after its own
// joints: with the names of kTailNames, the lengths of FingerOffset_m, and local rotations that are
// the identity in the T-pose. Left out are fingers of a hand that the skeleton lacks, a joint whose
// name is in use, and a joint between a hand and existing joints of the same finger. Unchanged if
// no joint is missing, or if there would be more than kMaxSourceJoints.
Binding WithFingers(const Binding& binding, const TailSet& wanted);

// Binds the hands of a skeleton that may have no other joints: source_joint has only the hands. The
// axes follow from the hands: in the T-pose the fingers point sideways, and the index finger is in
// front of the little one. With a single finger +Y is up; fingers without a length, or a thumb
// alone, have canonical axes. `rest`: as in BindingSpec, for a T-pose as far as the hands are
// concerned (flat, palms down, fingers straight); empty: the identity. `given`: joint names set by
// hand. Refuses a skeleton without a finger below a hand, and fingers that do not fit this.
Result<BindingSpec> BindHands(const Skeleton& skeleton, const std::vector<Quat>& rest,
                              const JointNames& given = {});

}  // namespace styled::rig
