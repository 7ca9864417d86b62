#pragma once

#include <cstdint>
#include <limits>

#include "model/base/realtime.h"

namespace styled::decide {

// Predicts when a performer's next frame is due, by the sender's own clock. Shortly before, cold
// data is brought into the caches, and a loop in hybrid mode polls. One per performer; pipeline
// thread.
class Anticipation {
 public:
  // Longer than a sleeping thread takes to wake on a machine with a free core for it, and short
  // enough that prewarmed data stays in the caches (tests/bench/README.md).
  static constexpr std::int64_t kLead_ns = 100'000;
  static constexpr std::int64_t kPatience_ns = 250'000;  // how late the frame may be
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  // The next frame is expected at `due_ns`; kNever: unknown.
  STYLED_REALTIME void Await(std::int64_t due_ns) noexcept {
    due_ns_ = due_ns;
    prepared_ = due_ns == kNever;
  }
  // When to prepare for the frame; kNever once that is done.
  std::int64_t prepare_ns() const noexcept { return prepared_ ? kNever : due_ns_ - kLead_ns; }
  // Returns true once, when it is time to prepare. Returns false for a frame that is overdue
  // already.
  STYLED_REALTIME bool Prepare(std::int64_t now_ns) noexcept {
    if (prepare_ns() > now_ns) return false;
    prepared_ = true;
    return now_ns < due_ns_ + kPatience_ns;
  }
  // Whether the frame is prepared for and not overdue yet.
  bool Expects(std::int64_t now_ns) const noexcept {
    return prepared_ && due_ns_ != kNever && now_ns < due_ns_ + kPatience_ns;
  }

 private:
  std::int64_t due_ns_ = kNever;
  bool prepared_ = true;
};

}  // namespace styled::decide
