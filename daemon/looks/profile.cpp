#include "daemon/looks/profile.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "model/base/hash.h"
#include "model/base/text.h"

namespace styled::pipeline {

namespace {

// Replaces a style's name by its proper spelling. An error if the network has no such style.
Status ProperName(const net::Styles& styles, std::string& style) {
  const int index = net::FindStyle(styles, style);
  if (index >= 0) {
    style = styles[static_cast<std::size_t>(index)].name;
    return Status::Ok();
  }
  std::string why = "no style \"" + Printable(style, 80) + "\"; expected one of";
  constexpr std::size_t kListed = 40;
  std::size_t listed = 0, more = 0;
  for (std::size_t i = 1; i < styles.size(); ++i) {
    if (styles[i].retired || listed == kListed) {
      more += static_cast<std::size_t>(!styles[i].retired);
      continue;
    }
    why += (++listed == 1 ? " " : ", ") + styles[i].name;
  }
  if (more > 0) why += " and " + std::to_string(more) + " more";
  return Status::Error(why);
}

// The style itself, or the style of the same name that has variations; -1 if there is none. Neutral
// is the base of every mix and needs none.
int VariedStyle(const net::Styles& styles, int style) {
  return style == 0 ? 0 : net::VaryingStyle(styles, style);
}

// The style that is shown for one of the look's mix.
int ShownStyle(const v1::Look& look, const net::Styles& styles, int style) {
  const int varied = RequestsVariations(look) ? VariedStyle(styles, style) : style;
  return varied < 0 ? style : varied;
}

// 0, or 1 .. net::kVariations.
int VariationOf(const v1::Look& look, std::string_view performer) {
  const auto given = static_cast<int>(look.vary());
  if (!look.vary_each()) return given;
  const auto own = static_cast<int>(HashOf(performer) % net::kVariations);
  return (given + own) % net::kVariations + 1;
}

// The mix of a Settings that is being built: the requested styles, and the styles shown instead.
class Mix {
 public:
  explicit Mix(stylist::Settings& settings) : mix_(settings.mix) {}

  void Add(int asked, int shown, float weight) {
    for (std::size_t i = 0; i < used_; ++i) {
      // Different requested styles that are shown as the same one are added up. A style requested
      // twice is an error (Validate).
      if (mix_[i].style != shown || asked_[i] == asked) continue;
      mix_[i].weight += weight;
      return;
    }
    if (used_ == mix_.size()) return;
    asked_[used_] = asked;
    mix_[used_++] = {shown, weight};
  }

 private:
  std::array<net::StyleWeight, net::kMaxMix>& mix_;
  std::array<int, net::kMaxMix> asked_{};
  std::size_t used_ = 0;
};

}  // namespace

stylist::Settings Resolve(const v1::Look& look, const net::Styles& styles,
                          std::vector<std::string>& unknown, std::string_view performer) {
  stylist::Settings settings;
  settings.strength = look.strength();
  settings.transition_s = look.transition_ms() * 1e-3F;
  // Rounding must not make the longest one longer.
  if (look.transition_ms() == 1000 * net::kMaxTransition_s) {
    settings.transition_s = net::kMaxTransition_s;
  }
  settings.absolute = look.absolute();
  settings.parts = PartsOf(look);
  settings.root = look.root() == v1::ROOT_STRIDE ? stylist::Root::kStride : stylist::Root::kFollow;
  settings.variation = VariationOf(look, performer);
  settings.vary_amount = look.vary_amount();
  settings.drift_s = look.drift_s();
  if (!look.input_style().empty()) {
    const int input = net::FindStyle(styles, look.input_style());
    if (input < 0) unknown.push_back(look.input_style());
    settings.input_style = std::max(0, input);
  }
  Mix mix(settings);
  for (const auto& entry : look.mix()) {
    const int index = net::FindStyle(styles, entry.style());
    // Neutral as a target requires an input style to remove, which other weights may lack.
    if (index == 0 && settings.input_style == 0 && !look.input_style().empty()) continue;
    if (index < 0) {
      unknown.push_back(entry.style());
      continue;
    }
    mix.Add(index, ShownStyle(look, styles, index), entry.weight());
  }
  return settings;
}

std::string NotVaried(const v1::Look& look, const net::Styles& styles) {
  if (!RequestsVariations(look)) return "";
  for (const auto& entry : look.mix()) {
    const int index = net::FindStyle(styles, entry.style());
    if (index >= 0 && VariedStyle(styles, index) < 0) return entry.style();
  }
  return "";
}

std::vector<std::string> NetworksOf(const v1::Look& look, const net::Styles& styles) {
  std::vector<std::string> networks;
  for (const auto& entry : look.mix()) {
    const int index = net::FindStyle(styles, entry.style());
    networks.emplace_back(
        index < 0 ? "" : styles[static_cast<std::size_t>(ShownStyle(look, styles, index))].model);
  }
  return networks;
}

Status ProperNames(const net::Styles& styles, v1::Look& change) {
  for (auto& entry : *change.mutable_mix()) {
    if (Status status = ProperName(styles, *entry.mutable_style()); !status.ok()) return status;
  }
  if (change.input_style().empty()) return Status::Ok();
  if (Status status = ProperName(styles, *change.mutable_input_style()); !status.ok()) {
    return status;
  }
  if (net::FindStyle(styles, change.input_style()) == 0) change.set_input_style("");
  return Status::Ok();
}

const config::Preset* FindPreset(std::string_view name,
                                 const std::vector<config::Preset>& presets) {
  const auto preset = std::find_if(presets.begin(), presets.end(),
                                   [name](const config::Preset& p) { return p.name == name; });
  return preset == presets.end() ? nullptr : &*preset;
}

Status LookUp(const std::string& name, const std::vector<config::Preset>& presets,
              const net::Styles& styles, v1::Look& look) {
  v1::Look change;
  if (const config::Preset* const preset = FindPreset(name, presets)) {
    change = preset->look;
    change.set_preset(name);
  } else {
    change.add_mix()->set_style(name);
    change.mutable_mix(0)->set_weight(1);
  }
  if (Status status = ProperNames(styles, change); !status.ok()) return status;
  styled::Apply(change, look);
  std::vector<std::string> unknown;
  const auto error =
      stylist::Validate(Resolve(look, styles, unknown), static_cast<int>(styles.size()));
  return error == stylist::SettingsError::kNone ? Status::Ok() : Status::Error(Explain(error));
}

bool ReplaceStyle(const std::string& name, const std::string& to, v1::Look& look) {
  bool named = look.input_style() == name;
  if (named) look.set_input_style(to);
  auto& mix = *look.mutable_mix();
  for (int i = mix.size() - 1; i >= 0; --i) {
    if (mix[i].style() != name) continue;
    named = true;
    to.empty() ? mix.DeleteSubrange(i, 1) : mix[i].set_style(to);
  }
  if (named && to.empty()) look.clear_preset();
  return named;
}

std::vector<v1::Request> AsRequests(const Profile& profile) {
  std::vector<v1::Request> requests(profile.pinned ? 2 : 1);
  for (auto& request : requests) request.set_performer(profile.id);
  v1::Look& set = *requests.front().mutable_set();
  set = profile.look;
  set.clear_preset();
  set.set_clear(set.mix().empty());
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
      return "neutral is a target style only if input_style names the style to remove; use clear";
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
      return "unknown input style";
    case SettingsError::kVariation:
      return "vary is not a whole number within 0 to 99";
    case SettingsError::kVaryAmount:
      return "vary_amount is not within 0 to 1.5";
    case SettingsError::kDrift:
      return "drift_s is not within 0 to 600";
    case SettingsError::kUnknownContent:
      return "unknown content";
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

std::uint64_t BindingHash(const rig::Binding& binding) {
  const rig::BindingSpec& spec = binding.spec();
  Fnv1a hash;
  hash.Number(static_cast<std::int64_t>(SkeletonHash(spec.skeleton)));
  for (const int joint : spec.source_joint) hash.Number(joint);
  const auto add = [&hash](const rig::Quat& rotation) {
    const float sign = rotation.w() < 0 ? -1.0F : 1.0F;
    for (const float number : rotation.coeffs()) hash.Number(std::lround(1000 * sign * number));
  };
  for (const rig::Quat& rotation : spec.rest_rotations) add(rotation);
  add(spec.canonical_from_source);
  return hash.value();
}

}  // namespace styled::pipeline
