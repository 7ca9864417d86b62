#include <algorithm>
#include <cctype>
#include <charconv>

#include "daemon/config/config.h"
#include "daemon/config/keys.h"
#include "daemon/config/sources.h"
#include "model/base/read_file.h"
#include "model/base/text.h"
#include "model/base/toml_nesting.h"
#include "proto/rigs/types.h"

namespace styled::config {
namespace {

// The place of a node for errors: "styled.toml:12", or the override's place.
std::string Place(const toml::node& node, const std::string& origin, bool is_file) {
  if (!is_file) return origin;
  return origin + ":" + std::to_string(node.source().begin.line);
}

struct Layer {
  std::string origin;
  bool is_file = true;

  Status Refuse(const toml::node& node, const std::string& key, const std::string& what) const {
    constexpr std::size_t kLongestKey = 100;  // longer than any known key
    return Status::Error(Place(node, origin, is_file) + ": " + Printable(key, kLongestKey) + ": " +
                         what);
  }
  // Records where the key was set.
  void Note(const toml::node& node, const std::string& key, Config& config) const {
    config.places.insert_or_assign(key, Place(node, origin, is_file));
  }
};

template <typename T>
std::vector<std::string_view> Names(const std::vector<T>& rows) {
  std::vector<std::string_view> names;
  names.reserve(rows.size());
  for (const auto& row : rows) names.push_back(row.name);
  return names;
}

template <typename T>
Status ApplyKey(const Layer& layer, const std::string& section, const std::vector<Key<T>>& keys,
                std::string_view name, const toml::node& node, T& out) {
  const std::string full = section + "." + std::string(name);
  for (const auto& key : keys) {
    if (key.name != name) continue;
    const Status status = key.read(node, out);
    return status.ok() ? status : layer.Refuse(node, full, status.message());
  }
  return layer.Refuse(node, full, "unknown key" + Nearest(name, Names(keys)));
}

Status TooMany(const Layer& layer, const toml::node& node, const std::string& section) {
  return layer.Refuse(node, section, "expected at most " + std::to_string(kMaxEntries));
}

Status ApplyPreset(const Layer& layer, std::string_view name, const toml::node& node,
                   Config& config) {
  Preset preset;
  preset.name = name;
  preset.place = Place(node, layer.origin, layer.is_file);
  const std::string full = "presets." + preset.name;
  layer.Note(node, full, config);
  if (!IsName(name)) {
    return layer.Refuse(node, full, "a preset's name has 1 to 32 of A-Z a-z 0-9 _ -");
  }
  const Status status = ReadPreset(node, preset);
  if (!status.ok()) return layer.Refuse(node, full, status.message());
  std::erase_if(config.presets, [&preset](const Preset& p) { return p.name == preset.name; });
  if (config.presets.size() == kMaxEntries) return TooMany(layer, node, "presets");
  config.presets.push_back(std::move(preset));
  return Status::Ok();
}

Status ApplySources(const Layer& layer, const toml::node& node, Config& config) {
  const toml::array* tables = node.as_array();
  if (tables == nullptr || !tables->is_array_of_tables()) {
    return layer.Refuse(node, "source", "expected [[source]] tables, in double brackets");
  }
  if (tables->size() > kMaxEntries) return TooMany(layer, node, "source");
  config.sources.clear();
  for (const auto& element : *tables) {
    Source source;
    const std::string place = "source." + std::to_string(config.sources.size());
    layer.Note(element, place, config);
    for (const auto& [key, value] : *element.as_table()) {
      Status status = ApplyKey(layer, "source", SourceKeys(), key.str(), value, source);
      if (!status.ok()) return status;
      layer.Note(value, place + "." + std::string(key.str()), config);
    }
    const rigs::SourceType& type = *rigs::FindSourceType(source.type);
    if (source.listen.empty()) source.listen = type.usual_address;
    if (source.listen.empty() && !type.usb) {
      return layer.Refuse(element, "source.listen", "missing; expected HOST:PORT");
    }
    config.sources.push_back(std::move(source));
  }
  return Status::Ok();
}

// Reads the [[name]] tables into `out`, one element each, replacing the former elements.
template <typename T>
Status ApplyTables(const Layer& layer, std::string_view section, const std::vector<Key<T>>& keys,
                   const toml::node& node, Config& config, std::vector<T>& out) {
  const std::string name(section);
  const toml::array* tables = node.as_array();
  if (tables == nullptr || !tables->is_array_of_tables()) {
    return layer.Refuse(node, name, "expected [[" + name + "]] tables, in double brackets");
  }
  if (tables->size() > kMaxEntries) return TooMany(layer, node, name);
  out.clear();
  for (const auto& element : *tables) {
    T table;
    table.place = Place(element, layer.origin, layer.is_file);
    const std::string place = name + "." + std::to_string(out.size());
    layer.Note(element, place, config);
    for (const auto& [key, value] : *element.as_table()) {
      Status status = ApplyKey(layer, name, keys, key.str(), value, table);
      if (!status.ok()) return status;
      layer.Note(value, place + "." + std::string(key.str()), config);
    }
    out.push_back(std::move(table));
  }
  return Status::Ok();
}

Status ApplySection(const Layer& layer, std::string_view name, const toml::node& node,
                    Config& config) {
  if (name == kSourceSection) return ApplySources(layer, node, config);
  if (name == kOutputSection) {
    return ApplyTables(layer, name, OutputKeys(), node, config, config.outputs);
  }
  if (name == kCueSection) return ApplyTables(layer, name, CueKeys(), node, config, config.cues);
  const auto section = std::find_if(Sections().begin(), Sections().end(),
                                    [&](const Section& s) { return s.name == name; });
  if (section == Sections().end() && name != kPresetsSection) {
    auto known = Names(Sections());
    known.push_back(kSourceSection);
    known.push_back(kOutputSection);
    known.push_back(kCueSection);
    known.push_back(kPresetsSection);
    return layer.Refuse(node, std::string(name), "unknown section" + Nearest(name, known));
  }
  const toml::table* table = node.as_table();
  if (table == nullptr) return layer.Refuse(node, std::string(name), "expected a [section]");
  for (const auto& [key, value] : *table) {
    Status status = name == kPresetsSection ? ApplyPreset(layer, key.str(), value, config)
                                            : ApplyKey(layer, std::string(name), section->keys,
                                                       key.str(), value, config);
    if (!status.ok()) return status;
    layer.Note(value, std::string(name) + "." + std::string(key.str()), config);
  }
  return Status::Ok();
}

Status ApplyText(const std::string& text, const std::string& name, Config& config) {
  if (const auto line = FindTooDeepToml(text)) {
    return Status::Error(name + ":" + std::to_string(*line) + ": " + TooDeepToml());
  }
  try {
    const toml::table table = toml::parse(text, name);
    for (const auto& [section, node] : table) {
      Status status = ApplySection({name, true}, section.str(), node, config);
      if (!status.ok()) return status;
    }
  } catch (const toml::parse_error& error) {
    const auto line = error.source().begin.line;
    return Status::Error(name + (line > 0 ? ":" + std::to_string(line) : std::string()) + ": " +
                         std::string(error.description()));
  }
  return Status::Ok();
}

// `value` as TOML. Text that does not parse becomes a string.
toml::table ValueTable(const std::string& value) {
  try {
    return toml::parse("value = " + value + "\n");
  } catch (const toml::parse_error&) {
    toml::table table;
    table.insert("value", value);
    return table;
  }
}

Status ApplySourceOverride(const Layer& layer, std::string_view rest, const toml::node& node,
                           Config& config) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), index);
  const auto used = static_cast<std::size_t>(end - rest.data());
  if (error != std::errc() || used >= rest.size() || rest[used] != '.') {
    return layer.Refuse(node, "source", "expected source.N.key, N counting from 0");
  }
  if (index >= config.sources.size()) {
    return layer.Refuse(node, "source." + std::to_string(index),
                        "there are " + std::to_string(config.sources.size()) + " sources");
  }
  const std::string place = "source." + std::to_string(index);
  const std::string_view key = rest.substr(used + 1);
  Status status = ApplyKey(layer, place, SourceKeys(), key, node, config.sources[index]);
  if (status.ok()) layer.Note(node, place + "." + std::string(key), config);
  return status;
}

Status ApplyOverride(const Override& override_, Config& config) {
  const Layer layer{override_.place, false};
  if (FindTooDeepToml(override_.value)) {
    return Status::Error(override_.place + ": " + TooDeepToml());
  }
  const toml::table value = ValueTable(override_.value);
  const toml::node& node = *value.get("value");
  const std::string_view key = override_.key;
  const std::size_t dot = key.find('.');
  const std::string_view section = key.substr(0, dot);
  const std::string_view rest = key.substr(dot + 1);
  if (section == kSourceSection) return ApplySourceOverride(layer, rest, node, config);
  if (section == kPresetsSection) return ApplyPreset(layer, rest, node, config);
  for (const auto& known : Sections()) {
    if (known.name == section) {
      Status status = ApplyKey(layer, std::string(section), known.keys, rest, node, config);
      if (status.ok()) layer.Note(node, override_.key, config);
      return status;
    }
  }
  return layer.Refuse(node, std::string(section),
                      "unknown section" + Nearest(section, Names(Sections())));
}

// The place of the key with which `complaint` begins, else the place of its table, else
// `otherwise`.
std::string PlaceOf(const Config& config, std::string_view complaint,
                    const std::string& otherwise) {
  std::string_view key = complaint.substr(0, complaint.find(": "));
  auto found = config.places.find(key);
  if (found == config.places.end()) found = config.places.find(key.substr(0, key.rfind('.')));
  return found == config.places.end() ? otherwise : found->second;
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

}  // namespace

Result<std::vector<Override>> EnvironmentOverrides(const char* const* environment) {
  std::vector<Override> overrides;
  for (; environment != nullptr && *environment != nullptr; ++environment) {
    const std::string_view entry = *environment;
    const std::size_t equals = entry.find('=');
    if (!entry.starts_with("STYLED_") || equals == std::string_view::npos) continue;
    const std::string variable(entry.substr(0, equals));
    const std::string words = Lower(variable.substr(7));
    for (const auto& section : Sections()) {
      const std::string name(section.name);
      if (!words.starts_with(name + "_")) continue;
      const std::string key = words.substr(name.size() + 1);
      const auto names = Names(section.keys);
      std::string full = name;
      full.append(".").append(key);
      if (std::find(names.begin(), names.end(), key) == names.end()) {
        std::string reason = variable;
        reason.append(": unknown key ").append(full).append(Nearest(key, names));
        return Status::Error(reason);
      }
      overrides.push_back({std::move(full), std::string(entry.substr(equals + 1)), variable});
    }
  }
  return overrides;
}

Result<Override> ParseOverride(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::size_t dot = text.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot > equals || dot == 0) {
    return Status::Error("--set " + text + ": expected section.key=value");
  }
  const std::string key = text.substr(0, equals);
  return Override{key, text.substr(equals + 1), "--set " + key};
}

Result<Config> Parse(const std::string& text, const std::string& name,
                     const std::vector<Override>& overrides) {
  Config config;
  if (!text.empty()) {
    const Status status = ApplyText(text, name, config);
    if (!status.ok()) return status;
  }
  for (const auto& override_ : overrides) {
    const Status status = ApplyOverride(override_, config);
    if (!status.ok()) return status;
  }
  AssignFaces(config.sources);
  const Status status = Validate(config);
  if (status.ok()) return config;
  const std::string place = PlaceOf(config, status.message(), name);
  return place.empty() ? status : Status::Error(place + ": " + status.message());
}

Result<Config> Load(const std::string& file, const std::vector<Override>& overrides) {
  if (file.empty()) return Parse("", "", overrides);
  const auto text = ReadFile(file, kMaxFileBytes);
  if (!text.ok()) return text.status();
  return Parse(text.value(), file, overrides);
}

}  // namespace styled::config
