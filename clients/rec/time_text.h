#pragma once

#include <cstdint>
#include <string>

#include "model/base/status.h"

namespace styled::rec {

// A point in time, Unix time in nanoseconds, from user input: "2026-11-26T14:03:05.5" of this
// machine's time zone, the same with "Z" at the end for UTC, or "-90s", "-15m", "-2h", "-1d" before
// `now_ns`. Errors state what was expected. Pinned by tests/unit/rec/time_text_test.cpp.
Result<std::int64_t> ParseTime(const std::string& text, std::int64_t now_ns);
// "2026-11-26T14:03:05.500Z", which ParseTime reads.
std::string TimeText(std::int64_t unix_ns);

}  // namespace styled::rec
