#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "model/gait/analysis.h"
#include "model/net/style_space.h"

namespace styled::phase {

// Room for sliders, of which some are in use.
inline constexpr std::size_t kSliderNumbers = 24;

// A style of the family: how a person moves in it, by gait phase. Rotations as in gait::Curve. Not
// for the hot path, which uses Tables (tables.h).
struct Style {
  // Everything is relative to a neutral, which the performer's own replaces: curves have the
  // identity as their mean, and series are rotation vectors after the performer's rotation. False:
  // everything is how the person moves, and the performer's own neutral is subtracted.
  bool difference = false;
  std::optional<gait::Gait> walk, run;
  std::optional<gait::Rotations> standing;
  gait::Rotations posture;  // where nothing else fits
  float seconds = 0;        // of the example
  float spread_rad = 0;     // gait::Analysis::spread_rad
  // How the style was changed by hand, as the difference of each slider from its usual value
  // (design.h). Gaits and postures contain it; what depends on time is computed in each step.
  std::array<float, kSliderNumbers> sliders{};

  Style() { posture.fill(body::Quat::Identity()); }
  bool has_gait() const { return walk || run; }
  bool is_pose() const;  // of an example that does not move
};

Style StyleOf(const gait::Analysis& example);

// The mean of styles: of each gait, and of standing and posture, over those styles that have it.
// All must be of the same kind (Style::difference). Weights are positive.
struct Weighted {
  Style style;
  float weight = 1;
};
Style MeanOf(std::span<const Weighted> styles);

// The style as a difference from `neutral`, which is not a difference. Gaits that only one of them
// has are left out; without a common one, postures are compared.
Style DifferenceOf(const Style& style, const Style& neutral);

// The style turned further by a difference, and the inverse. A difference without a run is added
// to a run as to a walk.
Style WithDifference(const Style& style, const Style& difference);
Style WithoutDifference(const Style& style, const Style& difference);

// The style as numbers (FORMAT.md), all of one size.
inline constexpr std::size_t kCodeSize = 8 + 2 * (8 * 63 + 5) + 2 * 63 + kSliderNumbers;
net::StyleCode ToCode(const Style& style);
// Of a code that IsCode. Rotations are normalized.
Style FromCode(const net::StyleCode& code);
// Whether the size, the first numbers and the ranges of all others are those of a code.
bool IsCode(const net::StyleCode& code);

}  // namespace styled::phase
