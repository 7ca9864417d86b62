#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "model/base/status.h"

namespace styled::runtime {

// "0.0.0.0:7000" or "[::]:7000"; whether the host is numeric is not checked. Port 0: the system
// chooses.
struct HostPort {
  std::string host;
  std::uint16_t port = 0;
};
// Errors quote the text and name what was expected. Pinned by tests/unit/daemon/config_test.cpp.
Result<HostPort> ParseHostPort(std::string_view text);

}  // namespace styled::runtime
