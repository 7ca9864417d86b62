#pragma once

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::stylist {

// Keeps the knees of `styled` from bending backwards, or further so than those of `in` do: a style
// that straightens a leg learned it on legs that were bent more. The bound is a rounded corner,
// which a straight leg styled 30 degrees backwards passes by 9. Smooth; a knee that is as the
// performer's stays so, and so does one that no leg could have. `share` 0 .. 1: how much of it.
STYLED_REALTIME void KeepKnees(const body::Pose& in, float share, body::Pose& styled) noexcept;

}  // namespace styled::stylist
