#include "daemon/styles/style_list.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "daemon/looks/profile.h"
#include "model/base/crc32c.h"
#include "model/base/text.h"

namespace styled::pipeline {
namespace {

constexpr std::size_t kShownName = 80;   // most bytes of a name that a reason quotes
constexpr std::size_t kListedMade = 16;  // most names

bool Names(const v1::Look& look, const net::Styles& styles, int number) {
  const auto is = [&](const std::string& name) {
    return !name.empty() && net::FindStyle(styles, name) == number;
  };
  return is(look.input_style()) ||
         std::any_of(look.mix().begin(), look.mix().end(),
                     [&is](const v1::StyleWeight& entry) { return is(entry.style()); });
}

// Reserved words, which have another meaning where a style can be named: all styles or performers,
// the state without a style, commands of stylectl and of OSC.
constexpr std::array<std::string_view, 16> kReserved{
    "all",  "bypass", "clear", "cue", "design", "each",  "error", "learn",
    "like", "none",   "panic", "pin", "preset", "reset", "unpin", "vary"};

bool IsReserved(std::string_view name) {
  return std::ranges::any_of(kReserved, [name](std::string_view word) {
    return std::ranges::equal(name, word, [](char a, char b) {
      return std::tolower(static_cast<unsigned char>(a)) == b;
    });
  });
}

// Refuses a style that the configuration file names: the daemon could not start again with that
// file.
Status CheckUnnamed(const RuntimeConfig& config, int number, const std::string& name) {
  const net::Styles& styles = config.network->model().styles;
  std::string where;
  for (const config::Preset& preset : config.presets) {
    if (Names(preset.look, styles, number)) where = "preset " + preset.name;
  }
  for (const Cue& cue : config.cues) {
    if (Names(cue.request.set(), styles, number)) where = "cue " + cue.name;
  }
  if (Names(config.style.look, styles, number)) where = "style.input_style";
  if (FindPreset(config.style.initial, config.presets) == nullptr &&
      !config.style.initial.empty() && net::FindStyle(styles, config.style.initial) == number) {
    where = "style.initial";
  }
  if (where.empty()) return {};
  return Malformed("\"" + name + "\": " + where +
                   " of the configuration names it; change the configuration first");
}

}  // namespace

Status CheckNewName(const std::string& name) {
  if (name.starts_with('-')) {
    return Malformed("name \"" + Printable(name, kShownName) +
                     "\": begins with - as an option does; expected a letter, a digit or _ first");
  }
  if (IsReserved(name)) {
    return Malformed(
        "name \"" + name +
        "\": is a word of stylectl and OSC with another meaning; expected another name");
  }
  return Status::Ok();
}

Status FindPlace(const RuntimeConfig& config, const std::string& name, Place& place) {
  if (!config::IsName(name) || name.size() > net::kMaxStyleName) {
    return Malformed("name \"" + Printable(name, kShownName) + "\": expected 1 to " +
                     std::to_string(net::kMaxStyleName) + " of A-Z a-z 0-9 _ -");
  }
  if (FindPreset(name, config.presets) != nullptr) {
    return Malformed("name \"" + name + "\": a preset has it");
  }
  const net::Styles& styles = config.network->model().styles;
  const int own = config.own_styles;
  place.replaced = net::FindStyle(styles, name);
  if (place.replaced >= 0 && place.replaced < own) {
    return Malformed("name \"" + name + "\": a style of the weights has it, \"" +
                     styles[static_cast<std::size_t>(place.replaced)].name + "\"");
  }
  const std::size_t others = config.made.size() - (place.replaced < 0 ? 0 : 1);
  if (others >= static_cast<std::size_t>(net::kMaxAdded)) {
    return Refused(v1::CODE_BUSY, "there are " + std::to_string(net::kMaxAdded) +
                                      " made styles already, which is the maximum");
  }
  const int count = static_cast<int>(styles.size());
  place.number = count;
  if (count < own + net::kMaxAdded + kSpare) return {};
  // The place retired longest ago: its style has faded out.
  place.number = std::max(config.last_place, own);
  do {
    place.number = place.number + 1 < count ? place.number + 1 : own;
  } while (!styles[static_cast<std::size_t>(place.number)].retired);
  return Status::Ok();
}

Status FindMade(const RuntimeConfig& config, const std::string& name,
                std::shared_ptr<const MadeStyle>& style) {
  const net::Styles& styles = config.network->model().styles;
  const int number = net::FindStyle(styles, name);
  if (number >= 0) {
    const std::string& proper = styles[static_cast<std::size_t>(number)].name;
    const auto found = config.made.find(proper);
    if (number < config.own_styles || found == config.made.end()) {
      return Malformed("\"" + proper + "\": is a style of the weights, expected one that was made");
    }
    style = found->second;
    return Status::Ok();
  }
  std::string reason = "no style \"" + Printable(name, kShownName) + "\"; those that were made are";
  std::size_t listed = 0;
  for (const auto& [made, unused] : config.made) {
    if (++listed > kListedMade) break;
    reason += " " + made;
  }
  if (config.made.size() > kListedMade) {
    reason += " and " + std::to_string(config.made.size() - kListedMade) + " more";
  }
  return Refused(
      v1::CODE_UNKNOWN_STYLE,
      config.made.empty() ? reason.substr(0, reason.find(';')) + "; there are none" : reason);
}

Status CheckCode(const net::StyleSpace& space, const net::StyleCode& code,
                 const std::string& what) {
  if (!space.IsCode(code)) {
    return Malformed(what + ": found " + std::to_string(code.size()) +
                     " numbers, expected as many as these weights' codes have, " +
                     std::to_string(space.MakeCode({.sources = {{.style = 0}}}).size()) +
                     " or more for an example");
  }
  // A code of huge numbers makes the distance overflow, so that it could not be limited.
  const bool usable =
      std::all_of(code.begin(), code.end(), [](float x) { return std::isfinite(x); }) &&
      std::isfinite(space.Nearest(code).distance);
  return usable ? Status::Ok() : Malformed(what + ": expected finite numbers, not huge ones");
}

Status NoEncoder(const net::Model& model) {
  return Refused(v1::CODE_NO_EXAMPLES,
                 "the weights of family \"" + model.family +
                     "\" have no style encoder; in the configuration model.gaits = \"open\" adds "
                     "one for walks and runs, model.examples = \"graph\" one for all motion");
}

void RetireStyle(int number, RuntimeConfig& config) {
  const auto made =
      config.made.find(config.network->model().styles[static_cast<std::size_t>(number)].name);
  if (made != config.made.end()) {
    config.retired[number] = made->second;
    config.made.erase(made);
  }
  config.network = config.network->Retired(number);
}

Status PutStyle(MadeStyle style, RuntimeConfig& config, bool in_place) {
  const net::StyleSpace* const space = config.network->space();
  if (space == nullptr) {
    return NoEncoder(config.network->model());
  }
  Place place;
  if (auto refusal = FindPlace(config, style.name, place); !refusal.ok()) return refusal;
  if (auto refusal = CheckCode(*space, style.code, "code"); !refusal.ok()) return refusal;
  style.code = space->Limited(style.code);
  const net::NearestStyle nearest = space->Nearest(style.code);
  style.nearest = config.network->model().styles[static_cast<std::size_t>(nearest.style)].name;
  style.distance = nearest.distance;
  style.sliders = space->SlidersOf(style.code);
  if (in_place && place.replaced >= 0) {
    place.number = place.replaced;
  } else {
    if (place.replaced >= 0) RetireStyle(place.replaced, config);
    config.retired.erase(place.number);
    config.last_place = place.number;
  }
  config.network = config.network->With(place.number, {.name = style.name}, style.code);
  const std::string name = style.name;
  config.made[name] = std::make_shared<const MadeStyle>(std::move(style));
  return Status::Ok();
}

Places PlacesOf(const RuntimeConfig& config) {
  Places places;
  const net::Styles& styles = config.network->model().styles;
  for (auto i = static_cast<std::size_t>(config.own_styles); i < styles.size(); ++i) {
    places.entries.push_back({styles[i].name, styles[i].retired});
  }
  places.last = config.last_place;
  for (const auto& [number, style] : config.retired) {
    places.fading[static_cast<std::size_t>(number - config.own_styles)] = style;
  }
  return places;
}

bool HasPlaces(const RuntimeConfig& config, const Places& places) {
  const Places here = PlacesOf(config);
  return here.last == places.last && here.entries == places.entries &&
         std::ranges::all_of(places.fading, [&here](const auto& fading) {
           const auto found = here.fading.find(fading.first);
           return found != here.fading.end() && found->second->code == fading.second->code;
         });
}

Status ArrangeStyles(const Places& places, RuntimeConfig& config) {
  std::shared_ptr<const net::Stylizer> network = config.loaded;
  const net::StyleSpace* const space = network->space();
  if (places.entries.size() > kMostPlaces) {
    return Malformed("places: found " + std::to_string(places.entries.size()) +
                     ", expected at most " + std::to_string(kMostPlaces));
  }
  if (space == nullptr && !places.entries.empty()) {
    return Malformed("places: these weights have no style encoder");
  }
  std::set<std::string> placed;
  std::map<int, std::shared_ptr<const MadeStyle>> still;
  for (std::size_t i = 0; i < places.entries.size(); ++i) {
    const auto& [name, retired] = places.entries[i];
    const int number = config.own_styles + static_cast<int>(i);
    const auto made = config.made.find(name);
    if (retired) {
      const auto fading = places.fading.find(i);
      const bool fades = fading != places.fading.end();
      if (fades) still[number] = fading->second;
      // A place in which no performer fades any more accepts any code.
      network = network->With(
          number, {.name = name},
          fades ? fading->second->code : space->MakeCode({.sources = {{.style = 0}}}));
      network = network->Retired(number);
      continue;
    }
    if (made == config.made.end() || !placed.insert(name).second) {
      return Malformed("places: \"" + Printable(name, kShownName) +
                       "\": expected each style that was made, once");
    }
    network = network->With(number, {.name = name}, made->second->code);
  }
  std::erase_if(config.made, [&placed](const auto& made) { return !placed.contains(made.first); });
  std::erase_if(config.kept, [&placed](const auto& name) { return !placed.contains(name); });
  config.network = std::move(network);
  config.retired = std::move(still);
  config.last_place = places.last;
  return Status::Ok();
}

Status RenameStyle(const MadeStyle& style, const std::string& to, RuntimeConfig& config) {
  const int number = net::FindStyle(config.network->model().styles, style.name);
  if (to == style.name) return Malformed("name \"" + to + "\": is already its name");
  if (auto refusal = CheckNewName(to); !refusal.ok()) return refusal;
  Place place;
  if (auto refusal = FindPlace(config, to, place);
      !refusal.ok() && refusal.code() != v1::CODE_BUSY) {  // no free place is needed
    return refusal;
  }
  if (place.replaced >= 0 && place.replaced != number) {
    return Malformed("name \"" + to + "\": another style that was made has it");
  }
  if (auto refusal = CheckUnnamed(config, number, style.name); !refusal.ok()) return refusal;
  MadeStyle renamed = style;
  renamed.name = to;
  config.network = config.network->With(number, {.name = to}, style.code);
  config.made.erase(style.name);
  config.made[to] = std::make_shared<const MadeStyle>(std::move(renamed));
  return Status::Ok();
}

Status RemoveStyle(const MadeStyle& style, RuntimeConfig& config) {
  const int number = net::FindStyle(config.network->model().styles, style.name);
  if (auto refusal = CheckUnnamed(config, number, style.name); !refusal.ok()) return refusal;
  RetireStyle(number, config);
  return Status::Ok();
}

std::string HashText(std::uint32_t crc) {
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "crc32c:%08x", crc);
  return text.data();
}

std::string HashOfExample(const std::string& bytes) {
  return HashText(Crc32c(std::as_bytes(std::span(bytes.data(), bytes.size()))));
}

}  // namespace styled::pipeline
