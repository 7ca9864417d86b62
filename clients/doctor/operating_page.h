#pragma once

#include <string_view>

namespace styled::doctor {

// The text of daemon/OPERATING.md; made by embed.cmake.
std::string_view OperatingPage();

}  // namespace styled::doctor
