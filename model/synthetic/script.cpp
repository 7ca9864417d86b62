#include "model/synthetic/script.h"

#include <array>
#include <charconv>
#include <string>

namespace styled::synthetic {
namespace {

constexpr std::array<std::string_view, static_cast<std::size_t>(Motion::kCount)> kNames{
    "stand",      "walk",      "run",        "turn-left",   "turn-right", "wave-left",
    "wave-right", "wave-both", "raise-left", "raise-right", "raise-both"};
constexpr double kDefault_s = 4;

std::string AllNames() {
  std::string all;
  for (const std::string_view name : kNames) all += (all.empty() ? "" : ", ") + std::string(name);
  return all;
}

}  // namespace

std::string_view Name(Motion motion) noexcept { return kNames[static_cast<std::size_t>(motion)]; }

Result<std::vector<ScriptItem>> ParseScript(std::string_view text) {
  std::vector<ScriptItem> script;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
    const std::size_t colon = item.find(':');
    ScriptItem parsed{Motion::kCount, kDefault_s};
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      if (kNames[i] == item.substr(0, colon)) parsed.motion = static_cast<Motion>(i);
    }
    if (parsed.motion == Motion::kCount) {
      return Status::Error("script: '" + std::string(item) + "': expected one of " + AllNames());
    }
    if (colon != std::string_view::npos) {
      const std::string_view number = item.substr(colon + 1);
      const auto [end, error] =
          std::from_chars(number.data(), number.data() + number.size(), parsed.seconds);
      const bool whole = error == std::errc() && end == number.data() + number.size();
      if (!whole || !(parsed.seconds >= 0.1 && parsed.seconds <= 3600)) {
        return Status::Error("script: '" + std::string(item) +
                             "': expected seconds from 0.1 to 3600 after the colon");
      }
    }
    script.push_back(parsed);
  }
  return script;
}

}  // namespace styled::synthetic
