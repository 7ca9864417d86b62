#include "clients/oscquery/answers.h"

#include <algorithm>
#include <array>

namespace styled::oscquery {
namespace {

using nlohmann::json;

// The proposal's attributes. Nodes have some of them only.
constexpr std::array<std::string_view, 16> kAttributes{
    "FULL_PATH",   "CONTENTS",  "TYPE",   "ACCESS",        "VALUE", "RANGE",
    "DESCRIPTION", "TAGS",      "UNIT",   "EXTENDED_TYPE", "HTML",  "CRITICAL",
    "CLIPMODE",    "OVERLOADS", "LISTEN", "ICON"};

json HostInfo(const Description& description, const std::string& own_address) {
  return {{"NAME", description.name},
          {"OSC_IP", own_address},
          {"OSC_PORT", description.osc_port},
          {"OSC_TRANSPORT", "UDP"},
          {"EXTENSIONS", {{"ACCESS", true}, {"DESCRIPTION", true}, {"VALUE", false}}}};
}

// The node at `path`, or null. A slash at its end does not matter.
const json* Find(const json& tree, std::string_view path) {
  const json* node = &tree;
  while (true) {
    while (path.starts_with('/')) path.remove_prefix(1);
    if (path.empty()) return node;
    const std::string name(path.substr(0, path.find('/')));
    const auto children = node->find("CONTENTS");
    if (children == node->end()) return nullptr;
    const auto child = children->find(name);
    if (child == children->end()) return nullptr;
    node = &*child;
    path.remove_prefix(name.size());
  }
}

}  // namespace

Answer AnswerTo(std::string_view target, const Description& description,
                const std::string& own_address) {
  target = target.substr(0, target.find('#'));
  const std::size_t mark = std::min(target.find('?'), target.size());
  const std::string_view path = target.substr(0, mark);
  const std::string_view query = target.substr(std::min(mark + 1, target.size()));
  if (!path.starts_with('/')) return {400, "expected a path, e.g. /VMC/Ext"};
  if (query == "HOST_INFO") return {200, HostInfo(description, own_address).dump()};
  const json* node = Find(description.tree, path);
  if (node == nullptr) return {404, "no such OSC address is read here; / has all of them"};
  if (query.empty()) return {200, node->dump()};
  if (std::find(kAttributes.begin(), kAttributes.end(), query) == kAttributes.end()) {
    return {400, "no such attribute; expected HOST_INFO, CONTENTS, TYPE, ACCESS or DESCRIPTION"};
  }
  const auto attribute = node->find(query);
  if (attribute == node->end()) return {204, ""};
  return {200, json{{query, *attribute}}.dump()};
}

}  // namespace styled::oscquery
