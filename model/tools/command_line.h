#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace styled {

// The exit status for an invalid command line.
inline constexpr int kBadArguments = 2;

// Parses the command line. Returns the exit status if the program is to end: 0 after --help,
// kBadArguments after an error, which is printed.
inline std::optional<int> Parse(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadArguments;
  }
  return std::nullopt;
}

}  // namespace styled
