#pragma once

#include <cstddef>

namespace styled {

// Bytes of a frame's expressions and passed-on messages (fields 18 and 19 of SourceFrame and
// Frame); a larger face is left out.
inline constexpr std::size_t kMaxFace = 16384;

}  // namespace styled
