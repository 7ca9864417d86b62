#include "model/net/strict_json.h"

#include <algorithm>
#include <set>
#include <vector>

namespace styled::net {
namespace {

constexpr int kMaxDepth = 16;

// "line 3, column 7": of the byte before which the parser stopped, counted from 1.
std::string Place(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte > 0 ? byte - 1 : 0, text.size()));
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - begin + 1);
}

}  // namespace

std::string ParseStrictJson(std::string_view text, nlohmann::json& value) {
  using nlohmann::json;
  std::string error;
  std::vector<std::set<std::string>> keys;  // of the open objects
  const auto watch = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth > kMaxDepth) {
      if (error.empty()) error = "nested deeper than " + std::to_string(kMaxDepth);
      return false;
    }
    switch (event) {
      case json::parse_event_t::object_start:
        keys.emplace_back();
        break;
      case json::parse_event_t::object_end:
        keys.pop_back();
        break;
      case json::parse_event_t::key: {
        const auto& key = parsed.get_ref<const std::string&>();
        if (!keys.back().insert(key).second && error.empty()) error = "key '" + key + "' twice";
        break;
      }
      default:
        break;
    }
    return true;
  };
  try {
    value = json::parse(text, watch);
  } catch (const json::parse_error& fault) {
    value = json(json::value_t::discarded);
    if (error.empty()) error = "not JSON: " + Place(text, fault.byte);
  } catch (const json::exception&) {  // the only other fault: a number above all doubles
    value = json(json::value_t::discarded);
    if (error.empty()) error = "not JSON: a number out of range";
  }
  return error;
}

}  // namespace styled::net
