#include "daemon/pipeline/keeping.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "daemon/config/look_keys.h"
#include "model/base/read_file.h"
#include "model/base/toml_nesting.h"
#include "model/base/write_file.h"

namespace styled::pipeline {
namespace {

toml::table RestRow(const KeptRest& rest) {
  const auto add = [](toml::array& array, const rig::Quat& rotation) {
    for (const float value : rotation.coeffs()) array.push_back(static_cast<double>(value));
  };
  toml::array axes, rotations;
  add(axes, rest.canonical_from_source);
  for (const auto& rotation : rest.rotations) add(rotations, rotation);
  std::ostringstream skeleton;
  skeleton << std::hex << rest.skeleton;
  return toml::table{{"skeleton", skeleton.str()},
                     {"left_handed", rest.left_handed},
                     {"canonical_from_source", std::move(axes)},
                     {"rotations", std::move(rotations)}};
}

toml::table Row(const Profile& profile) {
  toml::table row = config::LookTable(profile.look);
  row.insert("pinned", profile.pinned);
  row.insert("has_come", profile.has_come);
  row.insert("absent_hours", profile.absent_hours);
  if (profile.rest) row.insert("rest", RestRow(*profile.rest));
  return row;
}

// A field with a value that no request could have set keeps its initial value.
v1::Look ReadLook(const toml::table& row) {
  v1::Look look = InitialLook();
  const auto read = [&look](std::string_view field, const toml::node* node) {
    if (node != nullptr) (void)config::ReadLookField(*FindLookField(field), *node, look);
  };
  // Files of version 0.1 store the fade in seconds, and use other names.
  if (const auto transition_s = row["transition_s"].value<double>()) {
    const toml::value<double> transition_ms(*transition_s * 1e3);
    read("transition_ms", &transition_ms);
  }
  read("input_style", row.get("own_style"));
  for (const LookField& field : kLookFields) {
    if (!field.former.empty()) read(field.name, row.get(field.former));
    read(field.name, row.get(field.name));
  }
  return look;
}

std::optional<KeptRest> ReadRest(const toml::table& row) {
  KeptRest rest;
  const std::string skeleton = row["skeleton"].value_or(std::string());
  rest.skeleton = std::strtoull(skeleton.c_str(), nullptr, 16);
  rest.left_handed = row["left_handed"].value_or(false);
  std::vector<float> values;
  for (const char* const key : {"canonical_from_source", "rotations"}) {
    const toml::array* array = row[key].as_array();
    if (array == nullptr) return std::nullopt;
    for (const auto& value : *array) values.push_back(value.value_or(0.0F));
  }
  if (values.size() < 8 || values.size() % 4 != 0) return std::nullopt;
  for (std::size_t i = 0; i < values.size(); i += 4) {
    rest.rotations.emplace_back(values[i + 3], values[i], values[i + 1], values[i + 2]);
    constexpr float kTolerance = 1e-3F;  // of the length of a rotation
    if (!(std::abs(rest.rotations.back().norm() - 1) < kTolerance)) return std::nullopt;
  }
  rest.canonical_from_source = rest.rotations.front();
  rest.rotations.erase(rest.rotations.begin());
  return rest;
}

Profile FromRow(std::string_view id, const toml::table& row) {
  Profile profile;
  profile.id = id;
  profile.configured = true;
  profile.look = ReadLook(row);
  profile.pinned = row["pinned"].value_or(false);
  if (const toml::table* rest = row["rest"].as_table()) profile.rest = ReadRest(*rest);
  // Older files have neither field. A calibrated performer has come.
  profile.has_come = row["has_come"].value_or(false) || profile.rest;
  constexpr std::int64_t kMost_h = 1'000'000;
  profile.absent_hours = static_cast<int>(
      std::clamp<std::int64_t>(row["absent_hours"].value_or(std::int64_t{0}), 0, kMost_h));
  return profile;
}

}  // namespace

std::string FormatProfiles(const std::vector<Profile>& profiles) {
  toml::table table;
  for (const auto& profile : profiles) table.insert_or_assign(profile.id, Row(profile));
  std::ostringstream text;
  text << "# Written by styled: the settings of its performers.\n" << table << "\n";
  return text.str();
}

Status WriteProfiles(const std::string& file, const std::vector<Profile>& profiles) {
  return WriteFileAtomically(file, FormatProfiles(profiles));
}

Result<std::vector<Profile>> ReadProfiles(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::vector<Profile>();
  const auto text = ReadFile(file, kMaxStateBytes);
  return text.ok() ? ParseProfiles(text.value(), file) : text.status();
}

Result<std::vector<Profile>> ParseProfiles(const std::string& text, const std::string& name) {
  std::vector<Profile> profiles;
  if (const auto line = FindTooDeepToml(text)) {
    return Status::Error(name + ":" + std::to_string(*line) + ": " + TooDeepToml());
  }
  try {
    const toml::table table = toml::parse(text, name);
    for (const auto& [id, node] : table) {
      const toml::table* const row = node.as_table();
      if (row == nullptr || (id.str() != "*" && !config::IsPerformerId(id.str()))) continue;
      profiles.push_back(FromRow(id.str(), *row));
    }
  } catch (const toml::parse_error& broken) {
    return Status::Error(name + ":" + std::to_string(broken.source().begin.line) + ": " +
                         std::string(broken.description()));
  }
  return profiles;
}

}  // namespace styled::pipeline
