#pragma once

#include <vector>

#include "daemon/config/config.h"
#include "daemon/looks/runtime_config.h"
#include "proto/styled/v1/journal.pb.h"

// The configuration that a daemon of a pair sends to its peer ([standby]): all settings that affect
// the poses and which performers are styled. Settings that may differ between machines are left
// out: addresses, interfaces, serial numbers, limits of sockets, folders. Long values are hashes
// (style_list.h). Start and reload only; allocates. Pinned by tests/unit/standby/setup_test.cpp.
namespace styled::pipeline {

// A row per source: "source suit".
std::vector<v1::Setting> SettingsOf(const std::vector<config::Source>& sources);
// All rows of the configuration, followed by `sources`.
v1::Setup SetupOf(const RuntimeConfig& config, const std::vector<v1::Setting>& sources);

}  // namespace styled::pipeline
