#pragma once

#include <array>
#include <cstdint>

#include "model/base/realtime.h"
#include "model/body/pose.h"

namespace styled::idle {

// The motion of a body that does nothing: it breathes, shifts its weight and blinks. A pure
// function of time and a seed; the motions of two seeds are unrelated. Allocates nothing; any
// thread. Pinned by tests/unit/idle/idle_test.cpp.
class Idle {
 public:
  explicit Idle(std::uint32_t seed);

  struct Amounts {
    float body = 1;  // of breath and sway: 0 none, 1 that of a person at rest (idle.cpp)
    float head = 0;  // of the head's own wandering; 0: its world rotation stays as it is
  };
  // Adds the motion at `time_s`, which must be continuous, to a pose in canonical axes. The feet
  // stay where they are, with their rotations. A body that does not stand upright (it sits, kneels
  // or lies) breathes and does not sway.
  STYLED_REALTIME void Add(double time_s, const Amounts& amounts, body::Pose& pose) const noexcept;
  // How far the eyelids are closed, 0 .. 1.
  STYLED_REALTIME float Blink(double time_s) const noexcept;

 private:
  STYLED_REALTIME float Wander(int which, double time_s, double period_s) const noexcept;
  STYLED_REALTIME float Breath(double time_s) const noexcept;

  std::uint32_t seed_;
  double breath_rate_, sway_rate_;   // of the usual
  std::array<double, 24> phases_{};  // turns
};

}  // namespace styled::idle
