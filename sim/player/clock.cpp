#include "sim/player/clock.h"

#include <ctime>

namespace styled::player {

namespace {
constexpr std::int64_t kSecond_ns = 1'000'000'000;
}

std::int64_t SteadyClock::Now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecond_ns + now.tv_nsec;
}

void SteadyClock::SleepUntil(std::int64_t deadline_ns) {
  timespec deadline{};
  deadline.tv_sec = deadline_ns / kSecond_ns;
  deadline.tv_nsec = deadline_ns % kSecond_ns;
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
}

}  // namespace styled::player
