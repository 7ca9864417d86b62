#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::body {

// The yaw (rad, about +Y, 0 = facing +Z) of the body's forward axis, from the line through the hips
// and the line through the shoulders of this frame.
STYLED_REALTIME float Heading_rad(const WorldPose& world) noexcept;

// Advances a causal one-pole low-pass of the heading by one frame: the share `keep` in [0, 1) of
// the former value is kept (0: unfiltered, as in a first frame). It filters the direction, as
// cosine and sine, not the angle, which jumps at 180 degrees. Returns the filtered heading, rad.
STYLED_REALTIME float FilterHeading(float raw_rad, float keep, float& cosine, float& sine) noexcept;

// The rotation about +Y by `heading_rad`.
STYLED_REALTIME Quat Yaw(float heading_rad) noexcept;

}  // namespace styled::body
