#pragma once

#include "model/base/realtime.h"

namespace styled::feet {

// Where the performer's floor is, from the heights at which the feet come to rest (each height less
// what that part of the foot has when it is planted, so that heels and toes agree). Falls within
// tenths of a second when a foot comes to rest lower, rises slowly when all that rests is higher
// (stairs, a rig that drifts); one wild frame moves it by millimetres. Metres, seconds.
// Pinned by tests/unit/feet/contacts_test.cpp.
class Floor {
 public:
  // `lowest_m`: the lowest part of either foot; `speed_mps`: how fast that part moves. Returns the
  // floor. The first call takes the height as it is.
  STYLED_REALTIME float Follow(float lowest_m, float speed_mps, float dt_s) noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = Floor(); }
  float height_m() const { return height_m_; }

 private:
  float height_m_ = 0;
  bool started_ = false;
};

}  // namespace styled::feet
