#pragma once

#include <toml++/toml.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"

namespace styled::config {

// One key of a section. `read` converts its TOML node into the struct, or returns what was
// expected.
template <typename T>
struct Key {
  std::string_view name;
  std::function<Status(const toml::node&, T&)> read;
};

struct Section {
  std::string_view name;
  std::vector<Key<Config>> keys;
};

// The tables of all keys, shared by the loader, the environment and error messages. [[source]],
// [[output]] and [[cue]] have tables of their own; [presets] has free keys.
const std::vector<Section>& Sections();
const std::vector<Key<Source>>& SourceKeys();
const std::vector<Key<Output>>& OutputKeys();
const std::vector<Key<Cue>>& CueKeys();
inline constexpr std::string_view kSourceSection = "source";
inline constexpr std::string_view kOutputSection = "output";
inline constexpr std::string_view kCueSection = "cue";
inline constexpr std::string_view kPresetsSection = "presets";

// Parses the value of presets.NAME: { style = weight, ... }.
Status ReadPreset(const toml::node& node, Preset& preset);

inline constexpr std::size_t kLongestName = 64;  // bytes of a key, joint or style that errors quote
// "expected WHAT, found NODE".
Status Expected(const std::string& what, const toml::node& node);

// Returns ", nearest is \"x\"" for the candidate closest to `text` by edit distance, or "" when
// none is close.
std::string Nearest(std::string_view text, const std::vector<std::string_view>& candidates);

}  // namespace styled::config
