#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace styled {

// Where the configuration came from, so that a reload can read it again.
struct Origin {
  std::string file;  // "" = none
  std::vector<config::Override> overrides;
  std::string ready_file;  // "" = none

  // The state file of a configuration; "" = settings are not kept.
  static std::string StateFile(const config::Config& config) {
    return config.state.dir.empty() ? "" : config.state.dir + "/performers.toml";
  }
};

}  // namespace styled
