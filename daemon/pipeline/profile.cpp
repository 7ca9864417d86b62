#include "daemon/pipeline/profile.h"

#include <algorithm>

#include "model/base/hash.h"
#include "model/base/text.h"
#include "proto/styled/body_parts.h"

namespace styled::pipeline {

stylist::Settings Resolve(const Look& look, const net::Styles& styles,
                          std::vector<std::string>& unknown) {
  stylist::Settings settings;
  settings.strength = look.strength;
  settings.transition_s = look.transition_s;
  settings.absolute = look.absolute;
  settings.parts = look.parts;
  if (!look.input_style.empty()) {
    const int own = net::FindStyle(styles, look.input_style);
    if (own < 0) unknown.push_back(look.input_style);
    settings.input_style = std::max(0, own);
  }
  std::size_t used = 0;
  for (const auto& [style, weight] : look.mix) {
    const int index = net::FindStyle(styles, style);
    // To be made neutral takes a style to take away, which other weights may lack.
    if (index == 0 && settings.input_style == 0 && !look.input_style.empty()) continue;
    if (index < 0) {
      unknown.push_back(style);
    } else if (used < settings.mix.size()) {
      settings.mix[used++] = {index, weight};
    }
  }
  return settings;
}

bool ProperNames(const net::Styles& styles, std::vector<std::pair<std::string, float>>& mix,
                 std::string& why) {
  for (auto& [style, weight] : mix) {
    const int index = net::FindStyle(styles, style);
    if (index < 0) {
      why = "no style \"" + Printable(style, 80) + "\"; expected one of";
      for (int i = 1; i < static_cast<int>(styles.size()); ++i) {
        why += (i == 1 ? " " : ", ") + styles[static_cast<std::size_t>(i)].name;
      }
      return false;
    }
    style = styles[static_cast<std::size_t>(index)].name;
  }
  return true;
}

bool LookUp(const std::string& name, const std::vector<config::Preset>& presets,
            const net::Styles& styles, Look& look, std::string& why) {
  const auto preset = std::find_if(presets.begin(), presets.end(),
                                   [&name](const config::Preset& p) { return p.name == name; });
  auto mix = preset != presets.end() ? preset->mix
                                     : std::vector<std::pair<std::string, float>>{{name, 1.0F}};
  if (!ProperNames(styles, mix, why)) return false;
  look.mix = std::move(mix);
  look.preset = preset != presets.end() ? name : "";
  std::vector<std::string> unknown;
  const auto error =
      stylist::Validate(Resolve(look, styles, unknown), static_cast<int>(styles.size()));
  if (error != stylist::SettingsError::kNone) why = Explain(error);
  return error == stylist::SettingsError::kNone;
}

std::vector<v1::Request> AsRequests(const Profile& profile) {
  std::vector<v1::Request> requests(profile.pinned ? 2 : 1);
  for (auto& request : requests) request.set_performer(profile.id);
  const Look& look = profile.look;
  v1::Set& set = *requests.front().mutable_set();
  for (const auto& [style, weight] : look.mix) {
    auto& entry = *set.add_mix();
    entry.set_style(style);
    entry.set_weight(weight);
  }
  set.set_clear(look.mix.empty());
  set.set_strength(look.strength);
  set.set_transition_ms(look.transition_s * 1e3F);
  set.set_absolute(look.absolute);
  AddParts(look.parts, *set.mutable_only());
  set.set_own_style(look.input_style);
  if (profile.pinned) requests.back().mutable_pin()->set_pinned(true);
  return requests;
}

std::string Explain(stylist::SettingsError error) {
  using stylist::SettingsError;
  switch (error) {
    case SettingsError::kNone:
      return "";
    case SettingsError::kUnknownStyle:
      return "unknown style";
    case SettingsError::kNeutralStyle:
      return "neutral is no target style of who is neutral already; use clear, or set an own style";
    case SettingsError::kDuplicateStyle:
      return "a style is named twice";
    case SettingsError::kWeight:
      return "a weight is not within 0 to 1.5";
    case SettingsError::kSum:
      return "weights, times a strength above 1, sum to more than 1.5";
    case SettingsError::kStrength:
      return "strength is not within 0 to 1.5";
    case SettingsError::kTransition:
      return "transition is not within 0 to 60000 ms";
    case SettingsError::kNoParts:
      return "no part of the body is styled; use clear";
    case SettingsError::kUnknownInputStyle:
      return "unknown own style";
  }
  return "";
}

std::uint64_t SkeletonHash(const rig::Skeleton& skeleton) {
  Fnv1a hash;
  for (std::size_t j = 0; j < skeleton.names.size(); ++j) {
    hash.Text(skeleton.names[j]);
    hash.Byte(0);
    hash.Number(skeleton.parents[j]);
  }
  return hash.value();
}

}  // namespace styled::pipeline
