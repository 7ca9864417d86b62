#pragma once

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::feet {

// How the styled body's way over the floor differs from the performer's: by nothing, unless the
// style scales it (model/stylist/stride.h). Canonical metres, +Y up; the vectors are horizontal.
struct Travel {
  body::Vec3 moved_m = body::Vec3::Zero();  // the styled hips less the performer's
  // Steps are longer by this share (shorter if negative), along this direction. Its length is 1,
  // or less where the performer hardly moves.
  float longer = 0;
  body::Vec3 along = body::Vec3::Zero();

  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(moved_m, longer, along); }
};

}  // namespace styled::feet
