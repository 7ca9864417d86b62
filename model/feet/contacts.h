#pragma once

#include <array>

#include "model/base/checkpoint.h"
#include "model/base/critically_damped.h"
#include "model/base/realtime.h"
#include "model/feet/floor.h"
#include "model/feet/legs.h"
#include "model/feet/options.h"

namespace styled::feet {

// Contact weights of the performer's own feet: 0 (free) .. 1 (planted) for each heel and toes. A
// part is planted while it is low (above the tracked floor) and slow. The weights change smoothly,
// because a lock that begins or ends at once is visible as a pop. The heel is represented by the
// ankle joint. Keeps fixed-size state, no allocation; one thread at a time. Pinned by
// tests/unit/feet/contacts_test.cpp.
class Contacts {
 public:
  struct Foot {
    float heel = 0, toes = 0;  // toes: 0 if the skeleton has none
    STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(heel, toes); }
  };

  // `placed`: the transforms of the input's legs.joints() in canonical space. The first frame after
  // Reset() has no speeds. A frame with dt_s = 0 (after a hole in the stream) keeps the speeds of
  // the last one.
  STYLED_REALTIME void Process(float dt_s, const Legs& legs, std::span<const Placed> placed,
                               const Options& options) noexcept;
  STYLED_REALTIME void Reset() noexcept { *this = Contacts(); }

  const Foot& foot(int side) const { return feet_[static_cast<std::size_t>(side)]; }
  // The height of a planted toe joint (of the ankle where there are no toes), canonical metres.
  float floor_m() const { return floor_.height_m(); }
  // Bit 0 left, bit 1 right: set if the heel's or the toes' weight is above 0.5.
  std::uint32_t bits() const;
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(parts_, feet_, floor_, started_); }

 private:
  struct Part {
    Vec3 last_m = Vec3::Zero();
    Vec3 velocity_mps = Vec3::Zero();
    CriticallyDamped weight;
    STYLED_REALTIME void Carry(Checkpoint& c) noexcept { c(last_m, velocity_mps, weight); }
  };
  float Speed(Part& part, const Vec3& position_m, float dt_s) noexcept;

  std::array<std::array<Part, 2>, kLegs> parts_;  // heel, toes
  std::array<Foot, kLegs> feet_;
  Floor floor_;
  bool started_ = false;
};

}  // namespace styled::feet
