#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace styled::config {

// Checks that depend on the machine, for --check-config. Warnings concern what may appear later (a
// missing network interface), the error what will fail at the start (a recording folder that cannot
// be created). Reads the machine's interfaces and folders, changes nothing. Pinned by
// tests/unit/daemon/config_test.cpp.
std::vector<std::string> MissingInterfaces(const Config& config);
Status CheckRecordFolder(const std::string& file);

}  // namespace styled::config
