#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "clients/rec/outlet.h"
#include "proto/recording/reader.h"
#include "sim/player/clock.h"

namespace styled::rec {

struct PlayOptions {
  double speed = 1;  // > 0; infinity: as fast as possible
  bool loop = false;
  double from_s = 0, until_s = std::numeric_limits<double>::infinity();  // since the first record
};

struct PlayCounts {
  std::uint64_t records = 0;
  std::uint64_t passes = 0;
  double seconds = 0;  // played, in the recording's time, over all passes
  std::int64_t wall_ns = 0;
  std::int64_t most_late_ns = 0;  // the largest delay of a record
};

// Plays a recording into outlets, record by record in the file's order, each at its own time by an
// absolute clock. Overdue records are played at once; none is skipped. Returns at the end (with
// `loop`: never), when `stop` is set, or on an outlet's error. Pinned by
// tests/unit/rec/play_test.cpp.
Status Play(recording::Reader& reader, const PlayOptions& options, player::Clock& clock,
            const std::vector<Outlet*>& outlets, const std::atomic<bool>& stop, PlayCounts& counts);

}  // namespace styled::rec
