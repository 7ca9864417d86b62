#pragma once

#include <cstdint>

namespace styled::player {

// Where a player gets its time from: passed in, so that tests move a fake one and never sleep.
// Nanoseconds of any monotonic clock.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t Now_ns() = 0;
  // Returns at `deadline_ns`, or earlier on a signal; at once where it has passed.
  virtual void SleepUntil(std::int64_t deadline_ns) = 0;
};

// CLOCK_MONOTONIC, slept on absolutely: what one sleep is late, the next is not.
class SteadyClock final : public Clock {
 public:
  std::int64_t Now_ns() override;
  void SleepUntil(std::int64_t deadline_ns) override;
};

}  // namespace styled::player
