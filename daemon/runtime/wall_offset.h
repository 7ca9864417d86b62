#pragma once

#include <cstdint>
#include <cstdlib>

#include "daemon/runtime/clock.h"

namespace styled::runtime {

// Both clocks at one moment.
struct ClockReading {
  std::int64_t now_ns = 0, wall_ns = 0;
  std::int64_t offset_ns() const noexcept { return wall_ns - now_ns; }
};

// Reads both clocks. If the thread was interrupted between the two readings, they are repeated: the
// pause would appear as a difference of the clocks.
inline ClockReading ReadClocks(const Clock& clock) noexcept {
  constexpr std::int64_t kAtOnce_ns = 20'000;
  constexpr int kTries = 5;
  ClockReading best;
  std::int64_t best_ns = 0;
  for (int i = 0; i < kTries; ++i) {
    const std::int64_t before_ns = clock.Now_ns();
    const std::int64_t wall_ns = clock.Wall_ns();
    const std::int64_t after_ns = clock.Now_ns();
    const std::int64_t apart_ns = after_ns - before_ns;
    if (i == 0 || apart_ns < best_ns) {
      best = {before_ns + apart_ns / 2, wall_ns};
      best_ns = apart_ns;
    }
    if (best_ns <= kAtOnce_ns) break;
  }
  return best;
}

// Notices that the wall clock was set. A clock that NTP or PTP only steers runs evenly: both clocks
// are steered together. One thread. Pinned by tests/unit/daemon/source/arrival_clock_test.cpp.
class WallWatch {
 public:
  // Smaller steps are usual between synchronized machines and are not reported.
  static constexpr std::int64_t kStep_ns = 5 * kMillisecond_ns;

  // Call about once a second. Returns by how much the wall clock was set since the last call; 0:
  // not at all.
  std::int64_t Look(const Clock& clock) noexcept {
    const std::int64_t offset_ns = ReadClocks(clock).offset_ns();
    const std::int64_t step_ns = known_ ? offset_ns - offset_ns_ : 0;
    known_ = true;
    // Small differences are kept, so that they add up.
    if (step_ns != 0 && std::abs(step_ns) < kStep_ns) return 0;
    offset_ns_ = offset_ns;
    return step_ns;
  }

 private:
  bool known_ = false;
  std::int64_t offset_ns_ = 0;
};

}  // namespace styled::runtime
