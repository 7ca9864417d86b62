#pragma once

#include <algorithm>
#include <cstdint>

#include "model/base/realtime.h"

namespace styled::runtime {

// How late a frame is relative to its sender's own schedule: its transit took so much longer than
// the shortest transit of the last two to four seconds. The measure finds backlog wherever it
// gathers (network, kernel, daemon) without comparing the clocks of two machines. One object per
// session.
class Schedule {
 public:
  // `elapsed_ns`: source time since the session's first frame. `now_ns`: local time at which the
  // frame is examined.
  STYLED_REALTIME std::int64_t Lateness_ns(std::int64_t elapsed_ns, std::int64_t now_ns) noexcept {
    // The transit time plus an unknown constant offset between the clocks; only differences count.
    const std::int64_t way_ns = now_ns - elapsed_ns;
    if (!started_ || now_ns - turned_ns_ >= kTurn_ns) {
      previous_ns_ = started_ ? current_ns_ : way_ns;
      current_ns_ = way_ns;
      turned_ns_ = now_ns;
      started_ = true;
    }
    current_ns_ = std::min(current_ns_, way_ns);
    return way_ns - std::min(previous_ns_, current_ns_);
  }

  // The earliest local time at which a frame of that source time can be expected. Valid after the
  // first call of Lateness_ns().
  STYLED_REALTIME std::int64_t Due_ns(std::int64_t elapsed_ns) const noexcept {
    return elapsed_ns + std::min(previous_ns_, current_ns_);
  }

 private:
  static constexpr std::int64_t kTurn_ns = 2'000'000'000;
  bool started_ = false;
  std::int64_t previous_ns_ = 0,
               current_ns_ = 0;  // shortest transits of the previous and the current 2 s
  std::int64_t turned_ns_ = 0;
};

}  // namespace styled::runtime
