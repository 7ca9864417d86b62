#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "model/base/version.h"

namespace styled {

// The exit status for an invalid command line.
inline constexpr int kBadArguments = 2;

// Further lines of --version, e.g. about the weights.
using MoreOfVersion = std::function<std::string()>;

// Parses the command line, and adds --version. Returns the exit status if the program is to end: 0
// after --help and --version, kBadArguments after an error, which is printed.
inline std::optional<int> Parse(CLI::App& app, int argc, char** argv,
                                const MoreOfVersion& more = nullptr) {
  const std::string program = std::filesystem::path(argv[0]).filename();
  app.set_version_flag("--version",
                       [&] { return VersionText(program) + (more ? "\n" + more() : ""); });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadArguments;
  }
  return std::nullopt;
}

}  // namespace styled
