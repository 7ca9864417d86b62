#pragma once

#include <string>
#include <string_view>

#include "model/base/text.h"

namespace styled::config {

// A value of the configuration as an error message shows it. Allowed names have at most 32 bytes,
// ids 65, and numeric addresses fewer than 80.
inline std::string Shown(std::string_view text) { return Printable(text, 80); }

}  // namespace styled::config
