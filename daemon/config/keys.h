#pragma once

#include <toml++/toml.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"

namespace styled::config {

// One key of a section: reads its TOML node into the struct, or says what was expected there.
template <typename T>
struct Key {
  std::string_view name;
  std::function<Status(const toml::node&, T&)> read;
};

struct Section {
  std::string_view name;
  std::vector<Key<Config>> keys;
};

// The tables that loading, the environment and the complaints share. [[source]] has its own table;
// [presets] has free keys.
const std::vector<Section>& Sections();
const std::vector<Key<Source>>& SourceKeys();
inline constexpr std::string_view kSourceSection = "source";
inline constexpr std::string_view kPresetsSection = "presets";

// Reads the value of presets.NAME: { style = weight, ... }.
Status ReadPreset(const toml::node& node, Preset& preset);

// ", nearest is \"x\"" for the candidate closest to `text` by edit distance; "" when none is near.
std::string Nearest(std::string_view text, const std::vector<std::string_view>& candidates);

}  // namespace styled::config
