#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/rig/binding.h"

namespace styled::stylist {

// The upward shift of the styled body that makes its lowest foot as high as the input's. This is
// the coarse half of step 6: it places the whole body, so that the feet stage has to correct only
// each foot. "Lowest" is a soft minimum over feet and toes (1 cm wide), so the shift has no kink
// where one foot takes over from the other.

// On the canonical humanoid, metres along +Y.
STYLED_REALTIME float GroundShift_m(const body::Pose& input, const body::Pose& styled) noexcept;

// On the source skeleton, in its units, along its own up axis.
STYLED_REALTIME float GroundShift(const rig::Binding& binding, const rig::RigPose& input,
                                  const rig::RigPose& styled) noexcept;

// The same if the input is on another skeleton; in canonical metres.
STYLED_REALTIME float GroundShift_m(const rig::Binding& input_binding, const rig::RigPose& input,
                                    const rig::Binding& binding,
                                    const rig::RigPose& styled) noexcept;

// The vector by which the hips of `pose` move for a shift of `by_m` (canonical metres and axes):
// source units, in the frame of the hips' parent.
STYLED_REALTIME rig::Vec3 HipsShift(const rig::Binding& binding, const body::Vec3& by_m,
                                    const rig::RigPose& pose) noexcept;
// Moves the hips of `styled` by that.
STYLED_REALTIME void Shift(const rig::Binding& binding, const body::Vec3& by_m,
                           rig::RigPose& styled) noexcept;
// The same by `shift` source units along the source's up axis.
STYLED_REALTIME void ShiftUp(const rig::Binding& binding, float shift,
                             rig::RigPose& styled) noexcept;

}  // namespace styled::stylist
