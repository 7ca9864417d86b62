#pragma once

#include <cstdint>

namespace styled::stylevmc {

// Lets through at most `rate_hz` frames per second. A slower stream passes whole. A faster one is
// thinned evenly by its own clock, not by arrival, whose jitter would show as a stutter; arrival
// only bounds what a burst or a replay faster than life may send (to 1.25 of the rate, after four
// frames at once). One thread. Pinned by tests/unit/vmc_out/pace_test.cpp.
class RateCap {
 public:
  explicit RateCap(double rate_hz);  // > 0

  // Whether the frame with this source time, here at `now_ns` (monotonic), is to be sent.
  bool Take(std::uint64_t source_time_ns, std::int64_t now_ns);

 private:
  bool IsDue(std::uint64_t source_time_ns);

  std::int64_t period_ns_;
  bool started_ = false;
  std::uint64_t last_ns_ = 0;  // source time of the last frame, taken or not
  std::int64_t due_ns_ = 0;    // of the next one, by the source's clock
  double allowance_;           // frames that may still be sent now
  std::int64_t refilled_ns_ = 0;
};

// The clock of /VMC/Ext/T: seconds since the first frame, by the source's clock. It never stands
// nor goes back: over a restart of the rig or a jump of its clock it goes on by the time that
// passed here. One thread. Pinned by tests/unit/vmc_out/pace_test.cpp.
class Timeline {
 public:
  float Seconds(std::uint64_t source_time_ns, std::int64_t now_ns);

 private:
  bool started_ = false;
  std::int64_t elapsed_ns_ = 0;
  std::uint64_t last_source_ns_ = 0;
  std::int64_t last_now_ns_ = 0;
};

}  // namespace styled::stylevmc
