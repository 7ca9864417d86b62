#pragma once

#include <vector>

#include "daemon/config/config.h"
#include "daemon/looks/runtime_config.h"
#include "proto/styled/v1/journal.pb.h"

// What a daemon of a pair tells the other one of its configuration ([standby]): all that decides
// the poses and which performers are styled. What may differ between two machines is not in it:
// addresses, interfaces, serial numbers, limits of sockets, folders. Long values are hashes
// (style_list.h). Start and reload only; allocates. Pinned by tests/unit/standby/setup_test.cpp.
namespace styled::pipeline {

// A row per source: "source suit".
std::vector<v1::Setting> SettingsOf(const std::vector<config::Source>& sources);
// Of everything but sources, and then these.
v1::Setup SetupOf(const RuntimeConfig& config, const std::vector<v1::Setting>& sources);

}  // namespace styled::pipeline
