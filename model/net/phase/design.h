#pragma once

#include <array>
#include <span>

#include "model/net/phase/style.h"
#include "model/net/sliders.h"

namespace styled::phase {

// The sliders, in the order of Style::sliders. Names are those of the field: animators' and
// physiotherapists' words for posture and gait.
enum SliderIndex : std::size_t {
  kStoop,
  kLean,
  kChin,
  kShrug,
  kArmsOut,
  kArmsForward,
  kElbows,
  kArmsAcross,
  kArmSwing,
  kCrouch,
  kKneeLift,
  kStepWidth,
  kToesOut,
  kBounce,
  kSway,
  kTwist,
  kEnergy,
  kLag,
  kTremor,
  kWander,
  kHold,
  kSliderCount
};
static_assert(kSliderCount <= kSliderNumbers);

const std::array<net::Slider, kSliderCount>& Sliders();
// Designs to begin with: sneaky, drunk, robot, proud, scared, cold.
std::span<const net::Preset> Presets();

// The style with other values of its sliders; those that are not named keep theirs. An error names
// a slider that does not exist or is out of range, and what was expected.
Result<Style> WithSliders(const Style& style, std::span<const net::SliderValue> values);

}  // namespace styled::phase
