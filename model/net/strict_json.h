#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace styled::net {

// Parses `text` into `value`. Stricter than nlohmann: refuses a key that occurs twice in an object,
// and nesting deeper than 16. Returns an empty string, or the fault and its place. Never throws on
// bad input.
std::string ParseStrictJson(std::string_view text, nlohmann::json& value);

}  // namespace styled::net
