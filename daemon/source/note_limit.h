#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "daemon/runtime/clock.h"
#include "model/base/realtime.h"

namespace styled::source {

// Limits log lines that a remote sender can trigger at will: `burst` lines at once, then one a
// second. One object per kind of line; pipeline thread. Does not allocate. Pinned by
// tests/unit/daemon/source/tcp_test.cpp.
class NoteLimit {
 public:
  explicit NoteLimit(int burst = 1) : burst_ns_((burst - 1) * runtime::kSecond_ns) {}

  // Counts one more event. Returns 0 if no line may be logged now; otherwise the number of events
  // that the line reports: this one and those since the last line. `now_ns` must not go back.
  STYLED_REALTIME std::uint64_t Count(std::int64_t now_ns) noexcept {
    ++times_;
    const std::int64_t from_ns = std::max(paid_ns_, now_ns);
    if (from_ns - now_ns > burst_ns_) return 0;
    paid_ns_ = from_ns + runtime::kSecond_ns;
    return std::exchange(times_, 0);
  }

 private:
  std::int64_t burst_ns_;
  std::int64_t paid_ns_ = 0;  // each line costs a second
  std::uint64_t times_ = 0;
};

// The suffix of such a line: "", or " (12 times)".
inline std::string Times(std::uint64_t times) {
  return times > 1 ? " (" + std::to_string(times) + " times)" : "";
}

}  // namespace styled::source
