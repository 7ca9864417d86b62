#include "model/net/strict_json.h"

#include <set>
#include <vector>

namespace styled::net {
namespace {

constexpr int kMaxDepth = 16;

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
  value = json::parse(text, watch, /*allow_exceptions=*/false);
  if (error.empty() && value.is_discarded()) error = "not JSON";
  return error;
}

}  // namespace styled::net
