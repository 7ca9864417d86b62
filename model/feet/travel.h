#pragma once

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::feet {

// The difference between the styled body's path over the floor and the performer's. It is zero
// unless the style scales the path (model/stylist/stride.h). Canonical metres, +Y up; the vectors
// are horizontal.
struct Travel {
  body::Vec3 moved_m = body::Vec3::Zero();  // the styled hips minus the performer's
  // Steps are longer by this share (shorter if negative), along this direction. Its length is 1, or
  // less while the performer hardly moves.
  float longer = 0;
  body::Vec3 along = body::Vec3::Zero();

  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(moved_m, longer, along); }
};

}  // namespace styled::feet
