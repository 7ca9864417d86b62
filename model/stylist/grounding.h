#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/rig/binding.h"

namespace styled::stylist {

// How far up the styled body must be shifted for its lowest foot to be as high as the input's: the
// coarse half of step 6, which puts the whole body where the feet stage need only mend each foot.
// "Lowest" is a soft minimum over feet and toes (1 cm wide), so that the shift has no kink where
// one foot takes over from the other.

// On the canonical humanoid, metres along +Y.
STYLED_REALTIME float GroundShift_m(const body::Pose& input, const body::Pose& styled) noexcept;

// On the source skeleton, in its units along its own up axis.
STYLED_REALTIME float GroundShift(const rig::Binding& binding, const rig::RigPose& input,
                                  const rig::RigPose& styled) noexcept;

// The same where the input is on another skeleton, in canonical metres.
STYLED_REALTIME float GroundShift_m(const rig::Binding& input_binding, const rig::RigPose& input,
                                    const rig::Binding& binding,
                                    const rig::RigPose& styled) noexcept;

// Moves the hips of `styled` by `shift` source units along the source's up axis.
STYLED_REALTIME void ShiftUp(const rig::Binding& binding, float shift,
                             rig::RigPose& styled) noexcept;

}  // namespace styled::stylist
