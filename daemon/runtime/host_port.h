#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "model/base/status.h"

namespace styled::runtime {

// A parsed "0.0.0.0:7000" or "[::]:7000", the host without brackets. Whether the host is numeric is
// not checked. Port 0 lets the system choose.
struct HostPort {
  std::string host;
  std::uint16_t port = 0;
};
// Errors quote the text and name what was expected. Pinned by
// tests/unit/daemon/config/config_test.cpp.
Result<HostPort> ParseHostPort(std::string_view text);

}  // namespace styled::runtime
