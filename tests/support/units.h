// Numbers that many tests name.
#pragma once

#include <cstdint>
#include <limits>

namespace styled::support {

inline constexpr std::int64_t kMs = 1'000'000;             // nanoseconds
inline constexpr std::int64_t kSecond_ns = 1'000'000'000;  // nanoseconds
inline constexpr float kDegrees = 57.29578F;               // in a radian
inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

}  // namespace styled::support
