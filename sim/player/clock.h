#pragma once

#include <cstdint>

namespace styled::player {

// The clock of a player, passed in so that tests use a fake clock and never sleep. Times are
// nanoseconds of a monotonic clock.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t Now_ns() = 0;
  // Returns at `deadline_ns`; earlier on a signal; at once if the deadline has passed.
  virtual void SleepUntil(std::int64_t deadline_ns) = 0;
};

// CLOCK_MONOTONIC with absolute deadlines, so that delays of single sleeps do not add up.
class SteadyClock final : public Clock {
 public:
  std::int64_t Now_ns() override;
  void SleepUntil(std::int64_t deadline_ns) override;
};

}  // namespace styled::player
