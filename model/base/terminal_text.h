#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

#include "model/base/text.h"

namespace styled {

// Text of several lines for a terminal that may come from a file, a sender or another machine: each
// line as Printable makes it, so that no name moves the cursor, changes colours or the direction of
// writing. Allocates; any thread.
inline std::string ForTerminal(std::string_view text) {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  std::string shown;
  while (true) {
    const std::size_t end = text.find('\n');
    shown += Printable(text.substr(0, end), kAll);
    if (end == std::string_view::npos) return shown;
    shown += '\n';
    text.remove_prefix(end + 1);
  }
}

}  // namespace styled
