#pragma once

#include <cstdint>

namespace styled::stylevmc {

// Limits a stream to `rate_hz` frames per second. A slower stream passes unchanged. A faster one is
// thinned evenly by its source clock; thinning by arrival time would turn network jitter into
// stutter. Arrival times only limit a burst, or a replay faster than real time: to 1.25 times the
// rate, after at most four frames at once. One thread. Pinned by tests/unit/vmc_out/pace_test.cpp.
class RateCap {
 public:
  explicit RateCap(double rate_hz);  // > 0

  // Whether to send the frame with this source time that arrived at `now_ns` (monotonic clock).
  bool Admit(std::uint64_t source_time_ns, std::int64_t now_ns);

 private:
  bool IsDue(std::uint64_t source_time_ns);

  std::int64_t period_ns_;
  bool started_ = false;
  std::uint64_t last_ns_ = 0;  // source time of the last frame, sent or not
  std::int64_t due_ns_ = 0;    // source time from which the next frame is sent
  double allowance_;           // number of frames that may be sent now
  std::int64_t refilled_ns_ = 0;
};

// The clock of /VMC/Ext/T: seconds since the first frame, by the source's clock. It always
// increases: when the rig restarts or its clock jumps, it advances by the local time that passed.
// One thread. Pinned by tests/unit/vmc_out/pace_test.cpp.
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
