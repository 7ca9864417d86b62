#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace styled::config {

// What of a configuration only the machine can tell, for --check-config: warnings of what may come
// later (an interface that is not there), an error for what will not (a recording's folder that
// cannot be made). Reads the machine's interfaces and folders, changes nothing.
// Pinned by tests/unit/daemon/config_test.cpp.
std::vector<std::string> MissingInterfaces(const Config& config);
Status CheckRecordFolder(const std::string& file);

}  // namespace styled::config
