#pragma once

#include <algorithm>
#include <cstdint>

#include "model/base/realtime.h"

namespace styled::runtime {

// How far a frame is behind its sender's own schedule: its way took so much longer than the
// shortest way of the last two to four seconds. Finds backlog wherever it gathered, in the network,
// the kernel or here, without comparing two machines' clocks. One per session.
class Schedule {
 public:
  // `elapsed_ns`: source time since the session's first frame; `now_ns`: when the frame is looked
  // at.
  STYLED_REALTIME std::int64_t Lateness_ns(std::int64_t elapsed_ns, std::int64_t now_ns) noexcept {
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

  // When a frame of that source time is here at the earliest. After the first Lateness_ns.
  STYLED_REALTIME std::int64_t Due_ns(std::int64_t elapsed_ns) const noexcept {
    return elapsed_ns + std::min(previous_ns_, current_ns_);
  }

 private:
  static constexpr std::int64_t kTurn_ns = 2'000'000'000;
  bool started_ = false;
  std::int64_t previous_ns_ = 0, current_ns_ = 0;  // shortest ways
  std::int64_t turned_ns_ = 0;
};

}  // namespace styled::runtime
