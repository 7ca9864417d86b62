#pragma once

#include <cstddef>

namespace styled {

// Limits of a frame's props, the objects that the rig tracks (field 20 of SourceFrame and Frame).
// Further props, and those with a longer name, are left out.
inline constexpr std::size_t kMaxProps = 16;
inline constexpr std::size_t kMaxPropName = 64;  // bytes of UTF-8
// A bound of their bytes on the wire. A prop with a name of 64 bytes, position and rotation takes
// 101 bytes, so there is room for some props beyond the limit, which are then counted.
inline constexpr std::size_t kMaxPropBytes = 4096;

}  // namespace styled
