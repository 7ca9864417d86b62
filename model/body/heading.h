#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::body {

// The yaw (rad, about +Y, 0 = facing +Z) of the body's forward axis, from the line through the hips
// and the line through the shoulders of this frame.
STYLED_REALTIME float Heading_rad(const WorldPose& world) noexcept;

// The rotation about +Y by `heading_rad`.
STYLED_REALTIME Quat Yaw(float heading_rad) noexcept;

}  // namespace styled::body
