#include "daemon/pipeline/cues.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>

#include "daemon/pipeline/profile.h"
#include "model/body/parts.h"
#include "proto/styled/body_parts.h"

namespace styled::pipeline {
namespace {

constexpr std::int64_t kSecond = 1000;  // in a label; more frames than any rate has
constexpr std::int64_t kWinding = 2 * kSecond;

// What the cue says of style, preset or mix.
Status AddMix(const config::Cue& cue, const std::vector<config::Preset>& presets,
              const net::Styles& styles, Cue& made) {
  const auto preset = std::find_if(presets.begin(), presets.end(),
                                   [&cue](const auto& p) { return p.name == cue.preset; });
  if (!cue.preset.empty() && preset == presets.end()) {
    return Status::Error("preset: no preset \"" + cue.preset + "\"");
  }
  auto mix = cue.mix;
  if (!cue.style.empty()) mix.emplace_back(cue.style, 1.0F);
  if (!cue.preset.empty()) mix = preset->mix;
  std::string why;
  std::vector<std::pair<std::string, float>> own;
  if (!cue.input_style.empty()) own.emplace_back(cue.input_style, 1.0F);
  if (!ProperNames(styles, mix, why) || !ProperNames(styles, own, why)) {
    return Status::Error(why);
  }
  Look look;
  look.mix = mix;
  look.strength = cue.strength.value_or(1.0F);
  look.input_style = own.empty() ? "" : own.front().first;
  std::vector<std::string> unknown;
  const auto error =
      stylist::Validate(Resolve(look, styles, unknown), static_cast<int>(styles.size()));
  if (error != stylist::SettingsError::kNone) return Status::Error(Explain(error));
  if (!cue.preset.empty()) made.requests.emplace_back().mutable_preset()->set_name(cue.preset);
  v1::Set& set = *made.requests.emplace_back().mutable_set();
  for (const auto& [style, weight] : mix) {
    if (!cue.preset.empty()) break;  // it keeps its name
    auto& entry = *set.add_mix();
    entry.set_style(style);
    entry.set_weight(weight);
  }
  set.set_clear(cue.clear);
  if (cue.strength) set.set_strength(*cue.strength);
  if (cue.transition_s) set.set_transition_ms(*cue.transition_s * 1e3F);
  if (!cue.input_style.empty()) set.set_own_style(cue.input_style);
  return Status::Ok();
}

}  // namespace

std::int64_t TimecodeLabel(const Timecode& timecode) noexcept {
  const std::int64_t seconds =
      (std::int64_t{timecode.hours} * 60 + timecode.minutes) * 60 + timecode.seconds;
  return seconds * kSecond + std::min<std::int64_t>(timecode.frames, kSecond - 1);
}

std::string TimecodeText(std::int64_t label) {
  std::array<char, 32> text{};
  const auto part = [](std::int64_t value) { return static_cast<int>(value); };
  const std::int64_t seconds = label / kSecond;
  std::snprintf(text.data(), text.size(), "%02d:%02d:%02d:%02d", part(seconds / 3600),
                part(seconds / 60 % 60), part(seconds % 60), part(label % kSecond));
  return text.data();
}

std::optional<Timecode> ParseTimecode(std::string_view text) {
  constexpr std::array<std::uint32_t, 4> kMost{23, 59, 59, 239};
  std::array<std::uint32_t, 4> parts{};
  if (text.size() < 11 || text.size() > 12) return std::nullopt;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const char* const begin = text.data() + 3 * i;
    const char* const end = i < 3 ? begin + 2 : text.data() + text.size();
    const auto [stop, error] = std::from_chars(begin, end, parts[i]);
    if (error != std::errc() || stop != end || parts[i] > kMost[i]) return std::nullopt;
    const bool drop = i == 2 && *end == ';';
    if (i < 3 && *end != ':' && !drop) return std::nullopt;
  }
  Timecode timecode;
  timecode.hours = parts[0];
  timecode.minutes = parts[1];
  timecode.seconds = parts[2];
  timecode.frames = parts[3];
  timecode.drop_frame = text[8] == ';';
  return timecode;
}

bool Passes(std::int64_t at, std::int64_t last, std::int64_t now) noexcept {
  return last < at && at <= now && now - last <= kWinding;
}

Result<Cue> MakeCue(const config::Cue& cue, const std::vector<config::Preset>& presets,
                    const net::Styles& styles) {
  const auto refuse = [&cue](const std::string& what) {
    return Status::Error(cue.place + ": cue \"" + cue.name + "\": " + what);
  };
  Cue made{cue.name, std::nullopt, cue.performer, {}};
  if (!cue.at.empty()) {
    const auto timecode = ParseTimecode(cue.at);
    if (!timecode) return refuse("at: \"" + cue.at + "\"; expected HH:MM:SS:FF");
    made.at = TimecodeLabel(*timecode);
  }
  const bool looks = !cue.style.empty() || !cue.preset.empty() || !cue.mix.empty() || cue.clear ||
                     cue.strength || cue.transition_s || !cue.only.empty() ||
                     !cue.input_style.empty();
  const int mixes = static_cast<int>(!cue.style.empty()) + static_cast<int>(!cue.preset.empty()) +
                    static_cast<int>(!cue.mix.empty()) + static_cast<int>(cue.clear);
  if (mixes > 1) return refuse("expected one of style, preset, mix and clear");
  if (cue.panic == looks) {
    return refuse("expected what to do: panic alone, or style, preset, mix, clear, strength, ...");
  }
  if (cue.panic) {
    made.requests.emplace_back().mutable_panic();
    return made;
  }
  const Status status = AddMix(cue, presets, styles, made);
  if (!status.ok()) return refuse(status.message());
  if (!cue.only.empty()) {
    const auto parts = body::FindParts(cue.only);
    if (!parts) {
      return refuse("only: \"" + cue.only + "\"; expected, separated by commas, some of " +
                    std::string(body::kPartWords));
    }
    AddParts(*parts, *made.requests.back().mutable_set()->mutable_only());
  }
  // The fade comes first: it is of this change, too.
  std::rotate(made.requests.begin(), made.requests.end() - 1, made.requests.end());
  return made;
}

}  // namespace styled::pipeline
