#pragma once

#include <array>

#include "model/base/checkpoint.h"
#include "model/base/realtime.h"
#include "model/base/status.h"
#include "model/body/parts.h"
#include "model/feet/options.h"
#include "model/net/styles.h"
#include "model/stylist/tuning.h"

namespace styled::stylist {

// The style settings of one performer, and the options for all streams. Plain values, no
// allocation; any thread. Pinned by tests/unit/stylist/settings_test.cpp.

// Where the styled body is on the floor.
enum class Root {
  kFollow,  // where the performer is
  kStride,  // the performer's path, scaled by the style's effect on speed (stride.h)
};

// The first rule that settings break; NaN breaks every numeric rule.
enum class SettingsError {
  kNone,
  kUnknownStyle,    // an index that the network does not have
  kNeutralStyle,    // neutral as a target of neutral input
  kDuplicateStyle,  // a style twice in the mix
  kWeight,          // outside 0 .. net::kMaxStrength
  kSum,         // the weights, or the weights times strength, sum to more than net::kMaxStrength
  kStrength,    // outside 0 .. net::kMaxStrength
  kTransition,  // outside 0 .. net::kMaxTransition_s
  kNoParts,     // nothing would be styled
  kUnknownInputStyle,  // an index that the network does not have
  kVariation,          // outside 0 .. net::kVariations
  kVaryAmount,         // outside 0 .. net::kMaxStrength
  kDrift,              // outside 0 .. net::kMaxDrift_s
  kUnknownContent,     // a number that the network does not have
};

struct Settings;
// `style_count`: the network's number of styles, neutral included; `content_count`: of contents.
[[nodiscard]] STYLED_REALTIME SettingsError Validate(const Settings& settings, int style_count,
                                                     int content_count = 0) noexcept;

// The style of one performer. `mix` holds numbers and weights of the network's styles; the weights
// in effect are these times `strength`. Neutral, 0, may be a target only if `input_style` is
// another style.
struct Settings {
  std::array<net::StyleWeight, net::kMaxMix> mix;  // unused entries have style -1
  float strength = 1.0F;                           // 0 .. net::kMaxStrength; 0 fades to bypass
  // 0 .. net::kMaxTransition_s; fade from the settings before
  float transition_s = net::kUsualTransition_s;
  bool absolute = false;                // the paper's output instead of the detail-preserving one
  body::Parts parts = body::kAllParts;  // other parts stay as captured; not empty
  Root root = Root::kFollow;            // back to kFollow: from the offset reached so far
  int input_style = 0;  // style of the captured motion, which is removed; 0: neutral
  // The variation of styles that have any (net::StyleInfo::varies): 0, the style itself, to
  // net::kVariations. And its distance from the style: 0 .. net::kMaxStrength.
  int variation = 0;
  float vary_amount = 1;
  // 0 .. net::kMaxDrift_s; the time in which the variation changes to the next one, 0: constant.
  // Times below tuning::kFastestDrift_s count as that.
  float drift_s = 0;
  // The content of the performer's motion: a number of the network's contents,
  // net::kContentRecognized or net::kContentUnknown; the former if the network has none. A new one
  // is used at once.
  int input_content = net::kContentRecognized;

  // See model/base/checkpoint.h. Refuses what does not pass Validate.
  // Without contents the content has no bytes.
  STYLED_REALTIME void Carry(Checkpoint& c, int style_count, int content_count) noexcept {
    // A structured binding names all members, so that a new one does not compile until it is
    // carried here.
    auto& [mix, strength, transition_s, absolute, parts, root, input_style, variation, vary_amount,
           drift_s, input_content] = *this;
    for (net::StyleWeight& style : mix) c(style.style, style.weight);
    c(strength, transition_s, absolute, parts);
    bool strides = root == Root::kStride;
    c(strides);
    root = strides ? Root::kStride : Root::kFollow;
    c(input_style, variation, vary_amount, drift_s);
    if (content_count > 0) c(input_content);
    if (!c.reads() || !c.ok()) return;
    if (Validate(*this, style_count, content_count) != SettingsError::kNone) c.Refuse();
  }
};

// How streams are processed; the same for all performers. The defaults are those of styled.toml;
// model/stylist/tuning.h has their sources.
struct Options {
  // Delay of the low-pass on the style delta; it grows while the network reconstructs badly
  // (ChangeFilter). 0: none.
  float change_tau_s = tuning::kChangeTau_s;
  // A longer hole in source time, or one of more than kMaxStepsPerFrame network steps, restarts the
  // recurrent state.
  float gap_reset_s = tuning::kGapReset_s;
  // Duration of the cross-fade over such a restart.
  float restart_fade_s = tuning::kRestartFade_s;
  // A root step beyond this (and beyond 12 m/s) is held, canonical metres. After this many
  // consistent frames it is accepted.
  float jump_m = tuning::kJump_m;
  int jump_accept_frames = tuning::kJumpAcceptFrames;
  // Reconstruction error at which the style begins to fade out and at which it is gone; and the
  // time constant of the fade, 0: none.
  float out_of_domain_begin_rad = tuning::kOutOfDomainBegin_rad;
  float out_of_domain_end_rad = tuning::kOutOfDomainEnd_rad;
  float out_of_domain_fade_s = tuning::kOutOfDomainFade_s;
  // The same for the hips' tilt off upright (falls, lying), within tuning::kTiltFade_s.
  float tilt_begin_rad = tuning::kTiltBegin_rad;
  float tilt_end_rad = tuning::kTiltEnd_rad;
  // Shows the network the performer with the carriage of its own performers
  // (model/neutral/neutral.h).
  bool neutral = true;
  // A limb in a motion that the network does not know keeps its own motion (limb_gate.h).
  bool limb_gate = true;
  // The share of a style's posture that is kept when the network does not show it (posture.h); 0:
  // none.
  float posture = 1;
  // Time constant of the vertical shift of `ground`; 0: none.
  float ground_tau_s = tuning::kGroundTau_s;
  bool knees = true;           // no style bends a knee far backwards (knees.h)
  bool ground = true;          // the lowest foot is as high as the input's (grounding.h)
  bool feet = true;            // planted feet are held in place (feet.h)
  feet::Options feet_options;  // for `feet`
  // For a caller who then warps time by Output::cadence, so that steps come as often as in the
  // style. A stride then scales only the length of steps (ChangeOfGait). Never live, where time is
  // the performer's.
  bool own_cadence = false;
  bool bypass = true;  // false: bind and unbind every pose, even without a style

  // Names the first field that breaks a rule, and what was expected. NaN breaks every rule.
  Status Validate() const;

  friend bool operator==(const Options&, const Options&) = default;
};

}  // namespace styled::stylist
