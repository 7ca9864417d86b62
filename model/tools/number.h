#pragma once

#include <CLI/CLI.hpp>
#include <string>

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

}  // namespace styled
