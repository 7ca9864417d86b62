#pragma once

#include <array>

#include "model/body/parts.h"
#include "model/feet/options.h"
#include "model/net/styles.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {

// What one performer is to look like, and how streams are handled. Plain values, no allocation; any
// thread. Pinned by tests/unit/stylist/settings_test.cpp.

// The style of one performer. `mix` holds numbers of the network's styles and weights; the
// weights in force are those times `strength`. Neutral, 0, is a target only for a performer whose
// `input_style` is another.
struct Settings {
  std::array<net::StyleWeight, net::kMaxMix> mix;  // unused entries have style -1
  float strength = 1.0F;                           // 0 .. net::kMaxStrength; 0 fades to bypass
  float transition_s = tuning::kTransition_s;  // 0 .. net::kMaxTransition_s; fade from what was set
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
  kWeight,             // outside 0 .. net::kMaxStrength
  kSum,                // weights, or weights times strength, sum to more than net::kMaxStrength
  kStrength,           // outside 0 .. net::kMaxStrength
  kTransition,         // outside 0 .. net::kMaxTransition_s
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
  // Delay of the low-pass on the style delta, longer where the network reconstructs badly
  // (ChangeFilter); 0 = none.
  float change_tau_s = tuning::kChangeTau_s;
  // A longer hole in source time, or one of more network steps than kMaxStepsPerFrame, starts the
  // recurrent state anew.
  float gap_reset_s = tuning::kGapReset_s;
  // Cross-fade over such a start.
  float restart_fade_s = tuning::kRestartFade_s;
  // A root step beyond this (and 12 m/s) is held, canonical metres; after so many consistent frames
  // it is believed.
  float jump_m = tuning::kJump_m;
  int jump_accept_frames = tuning::kJumpAcceptFrames;
  // Reconstruction error where the style begins to fade out and where it is gone; time constant of
  // that fade, 0 = none.
  float out_of_domain_begin_rad = tuning::kOutOfDomainBegin_rad;
  float out_of_domain_end_rad = tuning::kOutOfDomainEnd_rad;
  float out_of_domain_fade_s = tuning::kOutOfDomainFade_s;
  // The same of the hips' tilt off upright (falls, lying), without a time constant.
  float tilt_begin_rad = tuning::kTiltBegin_rad;
  float tilt_end_rad = tuning::kTiltEnd_rad;
  // Smoothing of the vertical shift that `ground` takes; 0 = none.
  float ground_tau_s = tuning::kGroundTau_s;
  bool knees = true;           // no style bends a knee backwards
  bool ground = true;          // lowest foot as high as the input's
  bool feet = true;            // feet that the performer plants are held where they are
  feet::Options feet_options;  // how
  bool bypass = true;          // false: without style too, every pose goes through bind and unbind

  [[nodiscard]] OptionsError Validate() const noexcept;

  friend bool operator==(const Options&, const Options&) = default;
};

// What the field that `error` names must be, in terms of Options: for messages. "" for kNone.
const char* Expectation(OptionsError error) noexcept;

}  // namespace styled::stylist
