#pragma once

#include <array>

#include "model/base/critically_damped.h"
#include "model/base/realtime.h"
#include "model/feet/floor.h"
#include "model/feet/legs.h"
#include "model/feet/options.h"

namespace styled::feet {

// Which parts of the performer's own feet are on the floor: weights 0 (free) .. 1 (planted) that
// change smoothly, because a lock that begins or ends at once is seen as a pop. A part is planted
// while it is low (above the tracked floor) and slow. Heel stands for the ankle joint. A few frames
// of memory, no allocation; one thread. Pinned by tests/unit/feet/contacts_test.cpp.
class Contacts {
 public:
  struct Foot {
    float heel = 0, toes = 0;  // toes 0 where the skeleton has none
  };

  // `placed`: the input's legs.joints() in space. The first frame after Reset() has no speeds,
  // a frame with dt_s 0 (after a hole in the stream) keeps the last.
  STYLED_REALTIME void Process(float dt_s, const Legs& legs, std::span<const Placed> placed,
                               const Options& options) noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = Contacts(); }

  const Foot& foot(int side) const { return feet_[static_cast<std::size_t>(side)]; }
  // The height of a planted toe joint (of the ankle where there are no toes), canonical metres.
  float floor_m() const { return floor_.height_m(); }
  // Bit 0 left, bit 1 right: heel or toes are more planted than free.
  std::uint32_t bits() const;

 private:
  struct Part {
    Vec3 last_m = Vec3::Zero();
    Vec3 velocity_mps = Vec3::Zero();
    CriticallyDamped weight;
  };
  float Speed(Part& part, const Vec3& position_m, float dt_s) noexcept;

  std::array<std::array<Part, 2>, kLegs> parts_;  // heel, toes
  std::array<Foot, kLegs> feet_;
  Floor floor_;
  bool started_ = false;
};

}  // namespace styled::feet
