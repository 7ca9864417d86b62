#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/net/stylizer.h"
#include "model/stylist/settings.h"

namespace styled::stylist {

// The variation of a performer's styles over time: it fades from one setting to the next, and
// changes slowly if the settings request it. Time is source time. A point is a weight for each
// variation; they sum to 1 at most, and the rest is the style itself.
//
// The slow change is a uniform cubic B-spline. Its knots are Settings::variation and then
// variations by a hash of it and of their number: twice continuously differentiable, always within
// the variations' hull, the same in every replay. Fixed size, no allocation; one thread at a time.
// Pinned by tests/unit/stylist/variation_test.cpp.
class Variation {
 public:
  // Fades to the settings from the next Advance on. Only changed values restart: the same variation
  // continues. `at_once`: without a fade.
  STYLED_REALTIME void Aim(const Settings& settings, bool at_once) noexcept;
  STYLED_REALTIME void Advance(double dt_s) noexcept;

  // The variations in effect, by increasing number; each above 0, 1.5 in total at most.
  std::span<const net::VariationWeight> in_force() const { return {active_.data(), count_}; }
  bool fading() const {
    return elapsed_s_ < static_cast<double>(duration_s_) ||
           amount_elapsed_s_ < static_cast<double>(amount_duration_s_);
  }
  // See model/base/checkpoint.h.
  STYLED_REALTIME void Carry(Checkpoint& c) noexcept;

 private:
  using Point = std::array<float, net::kVariations + 1>;  // by number; [0] is not used
  static constexpr double kMostKnots = 1e15;  // beyond it a double has no share of a knot
  void AddKnots(float share) noexcept;
  int Knot(std::int64_t number) const noexcept;

  Point from_{}, point_{};  // start and end of the fade, for an amount of 1
  int variation_ = 0;
  float drift_s_ = 0;
  double phase_ = 0;  // of the slow change, in knots
  double elapsed_s_ = 0;
  float duration_s_ = 0;  // of the fade of the point
  float amount_ = 1, amount_from_ = 1, amount_to_ = 1;
  double amount_elapsed_s_ = 0;
  float amount_duration_s_ = 0;
  std::array<net::VariationWeight, net::kVariations> active_;
  std::size_t count_ = 0;
};

}  // namespace styled::stylist
