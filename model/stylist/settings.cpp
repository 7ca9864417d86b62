#include "model/stylist/settings.h"

#include <algorithm>
#include <utility>

namespace styled::stylist {
namespace {

constexpr float kRounding = 1e-4F;  // rounding of a sum of weights such as 0.5 + 0.7 + 0.3

// Written so that NaN is outside every range.
bool IsIn(float value, float low, float high) { return value >= low && value <= high; }

}  // namespace

SettingsError Validate(const Settings& settings, int style_count, int content_count) noexcept {
  if (settings.input_style < 0 || settings.input_style >= style_count) {
    return SettingsError::kUnknownInputStyle;
  }
  float sum = 0;
  for (std::size_t i = 0; i < settings.mix.size(); ++i) {
    const net::StyleWeight& style = settings.mix[i];
    if (style.style < 0) continue;
    if (style.style == 0 && settings.input_style == 0) return SettingsError::kNeutralStyle;
    if (style.style >= style_count) return SettingsError::kUnknownStyle;
    for (std::size_t j = 0; j < i; ++j) {
      if (settings.mix[j].style == style.style) return SettingsError::kDuplicateStyle;
    }
    if (!IsIn(style.weight, 0, net::kMaxStrength)) return SettingsError::kWeight;
    sum += style.weight;
  }
  if (!IsIn(settings.strength, 0, net::kMaxStrength)) return SettingsError::kStrength;
  if (!(sum * std::max(1.0F, settings.strength) <= net::kMaxStrength + kRounding)) {
    return SettingsError::kSum;
  }
  if (!IsIn(settings.transition_s, 0, net::kMaxTransition_s)) return SettingsError::kTransition;
  if ((settings.parts & body::kAllParts) == 0) return SettingsError::kNoParts;
  if (settings.variation < 0 || settings.variation > net::kVariations) {
    return SettingsError::kVariation;
  }
  if (!IsIn(settings.vary_amount, 0, net::kMaxStrength)) return SettingsError::kVaryAmount;
  if (!IsIn(settings.drift_s, 0, net::kMaxDrift_s)) return SettingsError::kDrift;
  const bool named = settings.input_content != net::kContentRecognized;
  if (named && (settings.input_content < net::kContentUnknown ||
                settings.input_content >= content_count || content_count == 0)) {
    return SettingsError::kUnknownContent;
  }
  return SettingsError::kNone;
}

Status Options::Validate() const {
  const std::pair<bool, const char*> rules[] = {
      {IsIn(change_tau_s, 0, 1), "change_tau: expected 0 to 1 s"},
      {IsIn(gap_reset_s, 0.01F, 10), "gap_reset: expected 0.01 to 10 s"},
      {IsIn(restart_fade_s, 0, 5), "restart_fade: expected 0 to 5 s"},
      {IsIn(jump_m, 0.1F, 100), "jump_m: expected 0.1 to 100"},
      {jump_accept_frames >= 1 && jump_accept_frames <= 1000,
       "jump_accept_frames: expected 1 to 1000"},
      {out_of_domain_begin_rad >= 0 && out_of_domain_begin_rad < out_of_domain_end_rad,
       "out_of_domain_begin_rad: expected 0 or more, less than out_of_domain_end_rad"},
      {IsIn(out_of_domain_fade_s, 0, 10), "out_of_domain_fade: expected 0 to 10 s"},
      {tilt_begin_rad >= 0 && tilt_begin_rad < tilt_end_rad,
       "tilt_begin_rad: expected 0 or more, less than tilt_end_rad"},
      {IsIn(posture, 0, 1), "posture: expected 0 to 1"},
      {IsIn(ground_tau_s, 0, 1), "ground_tau: expected 0 to 1 s"},
      {feet::IsValid(feet_options),
       "feet: expected options in their ranges (model/feet/options.h)"}};
  for (const auto& [holds, expected] : rules) {
    if (!holds) return Status::Error(expected);
  }
  return Status::Ok();
}

}  // namespace styled::stylist
