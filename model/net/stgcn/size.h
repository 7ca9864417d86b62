#pragma once

#include <cstddef>

namespace styled::stgcn {

// The number of values of an array of a shape.
inline std::size_t Size(int a, int b, int c = 1) {
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(b) * static_cast<std::size_t>(c);
}

}  // namespace styled::stgcn
