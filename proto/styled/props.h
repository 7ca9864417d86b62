#pragma once

#include <cstddef>

namespace styled {

// The objects of a frame that the rig tracks (field 20 of SourceFrame and Frame); further ones, and
// those with a longer name, are left out.
inline constexpr std::size_t kMaxProps = 16;
inline constexpr std::size_t kMaxPropName = 64;  // bytes of UTF-8
// Their bytes on the wire are fewer than this, which leaves room for some more of a sender's that
// are then counted: a name of 64 bytes, position and rotation take 101.
inline constexpr std::size_t kMaxPropBytes = 4096;

}  // namespace styled
