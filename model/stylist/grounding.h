#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"
#include "model/rig/binding.h"

namespace styled::stylist {

// Stands in for the feet stage: shifts the styled body vertically so that its lowest foot is as
// high as the input's. On the canonical humanoid, metres, +Y up.
STYLED_REALTIME void Ground(const body::Pose& input, body::Pose& styled) noexcept;

// The same on the source skeleton, in its units and along its own up axis.
STYLED_REALTIME void Ground(const rig::Binding& binding, const rig::RigPose& input,
                            rig::RigPose& styled) noexcept;

}  // namespace styled::stylist
