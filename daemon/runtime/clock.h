#pragma once

#include <cstdint>
#include <ctime>

namespace styled::runtime {

inline constexpr std::int64_t kMillisecond_ns = 1'000'000;
inline constexpr std::int64_t kSecond_ns = 1'000'000'000;

constexpr std::int64_t Nanoseconds(float seconds) {
  return static_cast<std::int64_t>(static_cast<double>(seconds) * 1e9);
}

// The source of time of every loop. It is passed in, so that a test can advance the time itself and
// never sleeps. Any thread may call.
class Clock {
 public:
  virtual ~Clock() = default;
  // Monotonic nanoseconds: never goes back. The origin is unspecified.
  virtual std::int64_t Now_ns() const noexcept = 0;
  // Unix time in nanoseconds.
  virtual std::int64_t Wall_ns() const noexcept = 0;
};

class SystemClock final : public Clock {
 public:
  std::int64_t Now_ns() const noexcept override { return Read(CLOCK_MONOTONIC); }
  std::int64_t Wall_ns() const noexcept override { return Read(CLOCK_REALTIME); }

 private:
  static std::int64_t Read(clockid_t id) noexcept {
    timespec time{};
    clock_gettime(id, &time);
    return time.tv_sec * kSecond_ns + time.tv_nsec;
  }
};

}  // namespace styled::runtime
