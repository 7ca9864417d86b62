#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <string>
#include <system_error>

#include "model/base/text.h"

namespace styled {

// A check for CLI options: a number from `low` to `high`. Unlike CLI::Range it refuses NaN.
inline CLI::Validator Number(double low, double high) {
  const std::string range = NumberText(low) + " to " + NumberText(high);
  return CLI::Validator(
      [=](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return good ? "" : "'" + text + "': expected a number from " + range;
      },
      range);
}

// The same for a whole number, in decimal digits. CLI11 alone takes -1 for an unsigned type.
inline CLI::Validator Whole(std::uint64_t low, std::uint64_t high) {
  const std::string range = std::to_string(low) + " to " + std::to_string(high);
  return CLI::Validator(
      [=](const std::string& text) {
        std::uint64_t value = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        const bool good = error == std::errc() && stop == end && value >= low && value <= high;
        return good ? "" : "'" + text + "': expected a whole number from " + range;
      },
      range);
}

}  // namespace styled
