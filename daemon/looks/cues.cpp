#include "daemon/looks/cues.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>

#include "daemon/looks/profile.h"

namespace styled::pipeline {
namespace {

constexpr std::int64_t kSecond = 1000;  // one second in a label, above any frame rate
constexpr std::int64_t kWinding = 2 * kSecond;

// The change that a cue makes, checked as for a performer without settings of its own.
Status MakeChange(const config::Cue& cue, const std::vector<config::Preset>& presets,
                  const net::Styles& styles, v1::Look& change) {
  change = cue.look;
  if (!cue.style.empty()) {
    change.add_mix()->set_style(cue.style);
    change.mutable_mix(0)->set_weight(1);
  }
  if (Status status = CheckLook(change); !status.ok()) return status;
  if (Status status = ProperNames(styles, change); !status.ok()) return status;
  v1::Look applied = change;
  if (!change.preset().empty()) {
    const config::Preset* const preset = FindPreset(change.preset(), presets);
    if (preset == nullptr) {
      return Status::Error("preset: no preset \"" + change.preset() + "\"");
    }
    *applied.mutable_mix() = preset->look.mix();
  }
  v1::Look look = InitialLook();
  styled::Apply(applied, look);
  std::vector<std::string> unknown;
  const auto error =
      stylist::Validate(Resolve(look, styles, unknown), static_cast<int>(styles.size()));
  return error == stylist::SettingsError::kNone ? Status::Ok() : Status::Error(Explain(error));
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

bool Passes(std::int64_t at, std::optional<std::int64_t> last, std::int64_t now) noexcept {
  if (!last) return at == now;
  return *last < at && at <= now && now - *last <= kWinding;
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
  const bool changes = !cue.style.empty() || !IsEmpty(cue.look);
  const int mixes = static_cast<int>(!cue.style.empty()) +
                    static_cast<int>(!cue.look.preset().empty()) +
                    static_cast<int>(cue.look.mix_size() > 0) + static_cast<int>(cue.look.clear());
  if (mixes > 1) return refuse("expected one of style, preset, mix and clear");
  if (cue.panic == changes) {
    return refuse("expected an action: panic alone, or style, preset, mix, clear, strength, ...");
  }
  if (cue.panic) {
    made.request.mutable_panic();
    return made;
  }
  const Status status = MakeChange(cue, presets, styles, *made.request.mutable_set());
  if (!status.ok()) return refuse(status.message());
  return made;
}

}  // namespace styled::pipeline
