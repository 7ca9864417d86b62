#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "daemon/runtime/clock.h"
#include "daemon/runtime/wall_offset.h"
#include "model/base/realtime.h"

namespace styled::source {

// Converts the kernel's timestamps of datagrams, which are in wall-clock time, to the monotonic
// clock. Setting the wall clock does not corrupt the result: a datagram arrived between the time at
// which the socket was last seen empty and now. A timestamp outside this interval is tried with the
// clocks' difference before the step. If it still does not fit, the datagram counts as arrived now.
// One per socket; one thread; allocates nothing. Pinned by
// tests/unit/daemon/source/arrival_clock_test.cpp.
class ArrivalClock {
 public:
  // Call before each reading of the socket, with the clock's Now_ns().
  STYLED_REALTIME void Begin(std::int64_t now_ns) noexcept { began_ns_ = now_ns; }
  // Call after it, before Arrival_ns.
  void Received(const runtime::Clock& clock) noexcept {
    const runtime::ClockReading reading = runtime::ReadClocks(clock);
    now_ns_ = reading.now_ns;
    if (reading.offset_ns() != offset_ns_) earlier_offset_ns_ = offset_ns_;
    offset_ns_ = reading.offset_ns();
  }
  // The time at which the datagram with this timestamp arrived. Never later than now.
  STYLED_REALTIME std::int64_t Arrival_ns(std::int64_t stamp_ns) const noexcept {
    for (const std::int64_t offset_ns : {offset_ns_, earlier_offset_ns_}) {
      const std::int64_t arrival_ns = stamp_ns - offset_ns;
      if (arrival_ns >= empty_ns_ - kSlack_ns && arrival_ns <= now_ns_ + kSlack_ns) {
        return std::min(arrival_ns, now_ns_);
      }
    }
    return now_ns_;
  }
  // Call after the last datagram of a reading; `drained`: no more datagrams wait in the socket.
  STYLED_REALTIME void End(bool drained) noexcept {
    if (drained) empty_ns_ = began_ns_;
  }
  std::int64_t now_ns() const noexcept { return now_ns_; }  // returned by the last Received()
  // The last time at which no datagram was waiting; the beginning of time before the first one.
  std::int64_t empty_ns() const noexcept { return empty_ns_; }

 private:
  // A datagram is stamped some time before the socket has it, and the clocks are not read at the
  // same moment.
  static constexpr std::int64_t kSlack_ns = 2 * runtime::kMillisecond_ns;
  std::int64_t began_ns_ = 0, now_ns_ = 0;
  std::int64_t empty_ns_ = std::numeric_limits<std::int64_t>::min() / 2;
  std::int64_t offset_ns_ = 0, earlier_offset_ns_ = 0;  // wall clock minus monotonic clock
};

}  // namespace styled::source
