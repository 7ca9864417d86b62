#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace styled::stylemon {

// Rates and latencies of one stream over the last seconds. All times are arguments, so that tests
// control them. One thread; allocates at construction and in Read.
class Meter {
 public:
  struct Reading {
    int frames = 0;      // in the window
    double rate_hz = 0;  // 0 below two frames
    // NaN if the window contains no frame. daemon_*: from receive to publish inside the daemon.
    // end_*: from receive in the daemon to arrival here, by wall clocks; across machines these must
    // be synchronized.
    double daemon_p50_ms = 0, daemon_p99_ms = 0, end_p50_ms = 0, end_p99_ms = 0;
    std::uint64_t dropped = 0;  // since the start, by gaps in `sequence`
  };

  explicit Meter(double window_s = 5.0) : window_ns_(static_cast<std::int64_t>(window_s * 1e9)) {}

  // A frame arrived at `now_ns` (monotonic clock); latencies in ns.
  void Add(std::int64_t now_ns, std::int64_t daemon_ns, std::int64_t end_ns, std::uint64_t missed);
  Reading Read(std::int64_t now_ns) const;

 private:
  struct Sample {
    std::int64_t at_ns, daemon_ns, end_ns;
  };
  static constexpr std::size_t kSamples = 4096;  // 5 s at 800 Hz
  std::int64_t window_ns_;
  std::vector<Sample> ring_ = std::vector<Sample>(kSamples);
  std::size_t count_ = 0;  // total since construction
  std::uint64_t dropped_ = 0;
};

}  // namespace styled::stylemon
