#include "daemon/config/table_keys.h"

#include <algorithm>
#include <array>
#include <utility>

#include "model/base/text.h"
#include "proto/styled/props.h"

namespace styled::config {

Status ReadTrackers(const toml::node& node, Source& source) {
  const std::string expected =
      "a table of trackers and body parts, e.g. { \"A1B2C3D4E5F6\" = \"chest\" }";
  const toml::table* table = node.as_table();
  if (table == nullptr) return Expected(expected, node);
  source.trackers.clear();
  for (const auto& [id, part] : *table) {
    if (!part.is_string()) return Expected(expected, part);
    source.trackers.push_back({std::string(id.str()), *part.value<std::string>()});
  }
  return Status::Ok();
}

Status ReadJoints(const toml::node& node, rig::JointNames& out) {
  const std::string expected =
      "a table of the humanoid's joints and the rig's, e.g. { leftUpperArm = \"L_Arm\" }";
  const toml::table* table = node.as_table();
  if (table == nullptr) return Expected(expected, node);
  out.clear();
  for (const auto& [joint, name] : *table) {
    const auto& rows = body::kHumanoid;
    const bool known = std::any_of(rows.begin(), rows.end(),
                                   [&](const body::JointRow& r) { return r.name == joint.str(); });
    if (!known) {
      std::vector<std::string_view> names;
      names.reserve(rows.size());
      for (const auto& row : rows) names.push_back(row.name);
      return Status::Error("\"" + Printable(joint.str(), kLongestName) +
                           "\" is not a joint of the canonical humanoid" +
                           Nearest(joint.str(), names));
    }
    if (!name.is_string()) return Expected(expected, name);
    out.emplace_back(joint.str(), *name.value<std::string>());
  }
  return Status::Ok();
}

Status ReadProps(const toml::node& node, Source& source) {
  const std::string expected =
      "a table of props and hands, e.g. { sword = \"right_hand\", chair = \"none\" }";
  constexpr std::array<std::pair<std::string_view, rig::Hand>, 4> kHands{
      {{"right_hand", rig::Hand::kRight},
       {"left_hand", rig::Hand::kLeft},
       {"none", rig::Hand::kNone},
       {"auto", rig::Hand::kAuto}}};
  const toml::table* table = node.as_table();
  if (table == nullptr) return Expected(expected, node);
  source.props.clear();
  for (const auto& [name, hand] : *table) {
    const std::string shown = "\"" + Printable(name.str(), kLongestName) + "\": ";
    if (name.str().empty() || name.str().size() > kMaxPropName) {
      return Status::Error(shown + "expected a prop's name, 1 to " + std::to_string(kMaxPropName) +
                           " bytes");
    }
    const auto word = hand.value<std::string_view>();
    const auto* const found = std::find_if(kHands.begin(), kHands.end(), [&word](const auto& row) {
      return word && row.first == *word;
    });
    if (found == kHands.end()) {
      const Status wrong =
          Expected("one of \"right_hand\", \"left_hand\", \"none\", \"auto\"", hand);
      return Status::Error(shown + wrong.message());
    }
    source.props.emplace(name.str(), found->second);
  }
  return Status::Ok();
}

Status ReadParts(const toml::node& node, Source& source) {
  std::string expected = "a list of";
  for (const std::string_view part : kMergedParts) {
    expected.append(part == kMergedParts.front() ? " \"" : ", \"").append(part).append("\"");
  }
  const toml::array* list = node.as_array();
  if (list == nullptr) return Expected(expected, node);
  source.parts.clear();
  for (const auto& part : *list) {
    const auto word = part.value<std::string>();
    if (!word || std::ranges::find(kMergedParts, *word) == kMergedParts.end()) {
      return Expected(expected, part);
    }
    source.parts.push_back(*word);
  }
  return Status::Ok();
}

Status ReadPerformers(const toml::node& node, Output& output) {
  const std::string expected = "a list of performers, e.g. [\"rig.anna\"]";
  const toml::array* list = node.as_array();
  if (list == nullptr) return Expected(expected, node);
  output.performers.clear();
  for (const auto& performer : *list) {
    if (!performer.is_string()) return Expected(expected, performer);
    output.performers.push_back(*performer.value<std::string>());
  }
  return Status::Ok();
}

}  // namespace styled::config
