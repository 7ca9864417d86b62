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
  double speed = 1;  // > 0; infinity: as fast as it goes
  bool loop = false;
  double from_s = 0, until_s = std::numeric_limits<double>::infinity();  // since the first record
};

struct PlayCounts {
  std::uint64_t records = 0;
  std::uint64_t passes = 0;
  double seconds = 0;  // played, of the recording's time, all passes together
  std::int64_t wall_ns = 0;
  std::int64_t most_late_ns = 0;  // the worst that a record was behind its time
};

// Plays a recording into outlets, record after record in the file's order, each at its own time by
// an absolute clock: what is overdue is played at once, nothing is skipped. Returns at the end
// (never, with `loop`), when `stop` is set, or on an outlet's error. Pinned by
// tests/unit/rec/play_test.cpp.
Status Play(recording::Reader& reader, const PlayOptions& options, player::Clock& clock,
            const std::vector<Outlet*>& outlets, const std::atomic<bool>& stop, PlayCounts& counts);

}  // namespace styled::rec
