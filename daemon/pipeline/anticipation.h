#pragma once

#include <cstdint>
#include <limits>

#include "model/base/realtime.h"

namespace styled::pipeline {

// When a performer's next frame is due, by the sender's own clock: what is cold is warmed shortly
// before, and a loop that may poll polls. One per performer.
class Anticipation {
 public:
  // Longer than a sleeping thread takes to wake on a machine that has a core for it; no longer than
  // what was warmed stays warm (tests/bench/README.md).
  static constexpr std::int64_t kLead_ns = 100'000;
  static constexpr std::int64_t kPatience_ns = 250'000;  // how late the frame may be
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  // The next frame is to arrive at `due_ns`; kNever: nobody knows.
  STYLED_REALTIME void Await(std::int64_t due_ns) noexcept {
    due_ns_ = due_ns;
    prepared_ = due_ns == kNever;
  }
  // When to prepare for it; kNever once that is done.
  std::int64_t prepare_ns() const noexcept { return prepared_ ? kNever : due_ns_ - kLead_ns; }
  // True once, when it is time to prepare. A frame that is overdue already is not prepared for.
  STYLED_REALTIME bool Prepare(std::int64_t now_ns) noexcept {
    if (prepare_ns() > now_ns) return false;
    prepared_ = true;
    return now_ns < due_ns_ + kPatience_ns;
  }
  // Prepared for, and not yet overdue.
  bool Expects(std::int64_t now_ns) const noexcept {
    return prepared_ && due_ns_ != kNever && now_ns < due_ns_ + kPatience_ns;
  }

 private:
  std::int64_t due_ns_ = kNever;
  bool prepared_ = true;
};

}  // namespace styled::pipeline
