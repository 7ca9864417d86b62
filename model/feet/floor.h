#pragma once

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"

namespace styled::feet {

// Tracks the height of the performer's floor from the heights at which the feet come to rest. (From
// each height the planted height of that part of the foot is subtracted, so that heels and toes
// agree.) The floor falls within tenths of a second when a foot comes to rest lower. It rises
// slowly when everything at rest is higher (stairs, a rig that drifts). One wild frame moves it by
// millimetres. Metres, seconds. Pinned by tests/unit/feet/contacts_test.cpp.
class Floor {
 public:
  // `lowest_m`: the height of the lowest part of either foot; `speed_mps`: the speed of that part.
  // Returns the floor's height. The first call sets it to `lowest_m`.
  STYLED_REALTIME float Follow(float lowest_m, float speed_mps, float dt_s) noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = Floor(); }
  float height_m() const { return height_m_; }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(height_m_, started_); }

 private:
  float height_m_ = 0;
  bool started_ = false;
};

}  // namespace styled::feet
