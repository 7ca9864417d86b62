#pragma once

#include <array>

#include "model/body/parts.h"
#include "model/feet/options.h"
#include "model/net/erd/network.h"

namespace styled::stylist {

// What one performer is to look like, and how streams are handled. Plain values, no allocation; any
// thread. Pinned by tests/unit/stylist/settings_test.cpp.

inline constexpr float kMaxTransition_s = 60.0F;

// The style of one performer. `mix` holds style indices of the network's metadata and weights; the
// weights in force are those times `strength`. Neutral, 0, is a target only for a performer whose
// `input_style` is another.
struct Settings {
  std::array<erd::ActiveStyle, erd::kMaxMix> mix;  // unused entries have style -1
  float strength = 1.0F;                           // 0 .. erd::kMaxStrength; 0 fades to bypass
  float transition_s = 0.1F;                       // 0 .. kMaxTransition_s; fade from what was set
  bool absolute = false;                // the paper's output instead of the detail-preserving one
  body::Parts parts = body::kAllParts;  // the others stay as captured; not empty
  int input_style = 0;                  // style of the captured motion, removed first; 0 = neutral
};

// The first rule that settings break; NaN breaks every one on numbers.
enum class SettingsError {
  kNone,
  kUnknownStyle,       // an index that the network does not have
  kNeutralStyle,       // neutral as a target of neutral input
  kDuplicateStyle,     // a style twice in the mix
  kWeight,             // outside 0 .. erd::kMaxStrength
  kSum,                // weights, or weights times strength, sum to more than erd::kMaxStrength
  kStrength,           // outside 0 .. erd::kMaxStrength
  kTransition,         // outside 0 .. kMaxTransition_s
  kNoParts,            // nothing would be styled
  kUnknownInputStyle,  // an index that the network does not have
};

// `style_count`: of the network, neutral included.
[[nodiscard]] SettingsError Validate(const Settings& settings, int style_count) noexcept;

// The first rule that options break, each named after the field that it bounds; NaN breaks every
// one.
enum class OptionsError {
  kNone,
  kChangeTau,        // change_tau_s outside 0 .. 1
  kGapReset,         // gap_reset_s outside 0.01 .. 10
  kRestartFade,      // restart_fade_s outside 0 .. 5
  kJump,             // jump_m outside 0.1 .. 100
  kJumpAccept,       // jump_accept_frames outside 1 .. 1000
  kOutOfDomain,      // not 0 <= out_of_domain_begin_rad < out_of_domain_end_rad
  kOutOfDomainFade,  // out_of_domain_fade_s outside 0 .. 10
  kTilt,             // not 0 <= tilt_begin_rad < tilt_end_rad
  kGroundTau,        // ground_tau_s outside 0 .. 1
  kFeet,             // feet_options do not pass feet::Validate
};

// How streams are handled; the same for all performers. Defaults are those of styled.toml; what
// picked them: model/stylist/tuning.h.
struct Options {
  float change_tau_s = 0.05F;  // delay of the low-pass on the style delta, longer where the network
                               // reconstructs badly (ChangeFilter); 0 = none
  float gap_reset_s = 0.25F;   // a longer hole in source time, or one of more network steps than
                               // kMaxStepsPerFrame, starts the recurrent state anew
  float restart_fade_s = 0.2F;  // cross-fade over such a start
  float jump_m = 1.0F;          // a root step beyond this (and 12 m/s) is held, canonical metres
  int jump_accept_frames = 10;  // consistent frames after which a jump is believed
  float out_of_domain_begin_rad = 0.7F;  // reconstruction error where the style begins to fade out
  float out_of_domain_end_rad = 1.1F;    // ... and where it is gone
  float out_of_domain_fade_s = 0.3F;     // time constant of that fade; 0 = none
  float tilt_begin_rad = 0.9F;  // hips' tilt off upright where it begins to fade, too: falls, lying
  float tilt_end_rad = 1.3F;    // ... and where it is gone, without a time constant
  bool knees = true;            // no style bends a knee backwards
  bool ground = true;           // lowest foot as high as the input's
  float ground_tau_s = 0.1F;    // smoothing of the vertical shift that this takes; 0 = none
  bool feet = true;             // feet that the performer plants are held where they are
  feet::Options feet_options;   // how
  bool bypass = true;           // false: without style too, every pose goes through bind and unbind

  [[nodiscard]] OptionsError Validate() const noexcept;

  friend bool operator==(const Options&, const Options&) = default;
};

// What the field that `error` names must be, in terms of Options: for messages. "" for kNone.
const char* Expectation(OptionsError error) noexcept;

}  // namespace styled::stylist
