#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace styled {

// For CLI options: a number from `low` to `high`. CLI::Range takes NaN for one.
inline CLI::Validator Number(double low, double high) {
  const auto text_of = [](double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
  };
  const std::string range = text_of(low) + " to " + text_of(high);
  return CLI::Validator(
      [=](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return good ? "" : "'" + text + "': expected a number from " + range;
      },
      range);
}

}  // namespace styled
