#include "daemon/looks/state_file.h"

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

void Add(const rig::Quat& rotation, toml::array& array) {
  for (const float value : rotation.coeffs()) array.push_back(static_cast<double>(value));
}

std::string Hex(std::uint64_t hash) {
  std::ostringstream text;
  text << std::hex << hash;
  return text.str();
}

toml::table RestRow(const KeptRest& rest) {
  toml::array axes, rotations;
  Add(rest.canonical_from_source, axes);
  for (const auto& rotation : rest.rotations) Add(rotation, rotations);
  return toml::table{{"skeleton", Hex(rest.skeleton)},
                     {"left_handed", rest.left_handed},
                     {"canonical_from_source", std::move(axes)},
                     {"rotations", std::move(rotations)}};
}

// A gait to a hundredth of a degree, so that a performer takes 6 KB.
toml::table GaitRow(const gait::Series& series, float seconds) {
  constexpr double kSteps = 1e4;  // per radian
  toml::array numbers;
  for (const float value : series.reshaped()) {
    numbers.push_back(std::round(static_cast<double>(value) * kSteps) / kSteps);
  }
  return toml::table{{"seconds", static_cast<double>(seconds)}, {"series", std::move(numbers)}};
}

// Leaves the values as they are without such a row.
void ReadGait(const toml::table& row, const char* key, gait::Series& series, float& seconds) {
  const toml::table* const gait = row[key].as_table();
  const toml::array* const numbers = gait == nullptr ? nullptr : (*gait)["series"].as_array();
  if (numbers == nullptr || numbers->size() != static_cast<std::size_t>(series.size())) return;
  gait::Series read;
  for (Eigen::Index i = 0; i < read.size(); ++i) {
    read.data()[i] = (*numbers)[static_cast<std::size_t>(i)].value_or(0.0F);
  }
  const float read_s = (*gait)["seconds"].value_or(0.0F);
  if (!read.allFinite() || read.cwiseAbs().maxCoeff() > 4 || !std::isfinite(read_s)) return;
  series = read;
  seconds = std::max(0.0F, read_s);
}

toml::table NeutralRow(const KeptNeutral& neutral) {
  toml::array rotations;
  for (const auto& rotation : neutral.known.own.rotations) Add(rotation, rotations);
  toml::table row{{"binding", Hex(neutral.binding)},
                  {"calibrated", neutral.known.calibrated},
                  {"body_s", static_cast<double>(neutral.known.body_s)},
                  {"arms_s", static_cast<double>(neutral.known.arms_s)},
                  {"rotations", std::move(rotations)}};
  const neutral::Known& known = neutral.known;
  constexpr float kWorthKeeping_s = 0.5F;
  if (known.walking_s > kWorthKeeping_s)
    row.insert("walk", GaitRow(known.walking, known.walking_s));
  if (known.running_s > kWorthKeeping_s) row.insert("run", GaitRow(known.running, known.running_s));
  return row;
}

toml::table Row(const Profile& profile) {
  toml::table row = config::LookTable(profile.look);
  row.insert("pinned", profile.pinned);
  row.insert("has_come", profile.has_come);
  row.insert("absent_hours", profile.absent_hours);
  if (profile.rest) row.insert("rest", RestRow(*profile.rest));
  if (profile.neutral) row.insert("neutral", NeutralRow(*profile.neutral));
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

std::uint64_t ReadHex(const toml::table& row, const char* key) {
  return std::strtoull(row[key].value_or(std::string()).c_str(), nullptr, 16);
}

// The rotations of a list of numbers, four numbers each; empty if the list is malformed.
std::optional<std::vector<rig::Quat>> ReadRotations(const std::vector<float>& values) {
  constexpr float kTolerance = 1e-3F;  // tolerance of a rotation's length
  std::vector<rig::Quat> rotations;
  if (values.size() % 4 != 0) return std::nullopt;
  for (std::size_t i = 0; i < values.size(); i += 4) {
    rotations.emplace_back(values[i + 3], values[i], values[i + 1], values[i + 2]);
    if (!(std::abs(rotations.back().norm() - 1) < kTolerance)) return std::nullopt;
  }
  return rotations;
}

std::optional<KeptNeutral> ReadNeutral(const toml::table& row) {
  KeptNeutral neutral;
  neutral.binding = ReadHex(row, "binding");
  neutral.known.calibrated = row["calibrated"].value_or(false);
  neutral.known.body_s = row["body_s"].value_or(0.0F);
  neutral.known.arms_s = row["arms_s"].value_or(0.0F);
  const toml::array* const array = row["rotations"].as_array();
  if (array == nullptr || !std::isfinite(neutral.known.body_s + neutral.known.arms_s)) {
    return std::nullopt;
  }
  std::vector<float> values;
  for (const auto& value : *array) values.push_back(value.value_or(0.0F));
  const auto rotations = ReadRotations(values);
  auto& own = neutral.known.own.rotations;
  if (!rotations || rotations->size() != own.size()) return std::nullopt;
  std::copy(rotations->begin(), rotations->end(), own.begin());
  ReadGait(row, "walk", neutral.known.walking, neutral.known.walking_s);
  ReadGait(row, "run", neutral.known.running, neutral.known.running_s);
  return neutral;
}

std::optional<KeptRest> ReadRest(const toml::table& row) {
  KeptRest rest;
  rest.skeleton = ReadHex(row, "skeleton");
  rest.left_handed = row["left_handed"].value_or(false);
  std::vector<float> values;
  for (const char* const key : {"canonical_from_source", "rotations"}) {
    const toml::array* array = row[key].as_array();
    if (array == nullptr) return std::nullopt;
    for (const auto& value : *array) values.push_back(value.value_or(0.0F));
  }
  auto rotations = ReadRotations(values);
  if (!rotations || rotations->size() < 2) return std::nullopt;
  rest.canonical_from_source = rotations->front();
  rest.rotations.assign(rotations->begin() + 1, rotations->end());
  return rest;
}

Profile FromRow(std::string_view id, const toml::table& row) {
  Profile profile;
  profile.id = id;
  profile.configured = true;
  profile.look = ReadLook(row);
  profile.pinned = row["pinned"].value_or(false);
  if (const toml::table* rest = row["rest"].as_table()) profile.rest = ReadRest(*rest);
  if (const toml::table* known = row["neutral"].as_table()) profile.neutral = ReadNeutral(*known);
  // Older files have neither field. A calibrated performer has been present.
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
