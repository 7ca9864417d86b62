#pragma once

#include <array>
#include <cstdint>

#include "model/base/realtime.h"

namespace styled::runtime {

// Latencies since the last Clear() in fixed buckets: 16 per octave, up to a minute, so that a
// percentile is at most 6 % too high. Larger latencies count in the last bucket. Allocates nothing;
// one thread.
class Histogram {
 public:
  STYLED_REALTIME void Add(std::int64_t latency_ns) noexcept;
  // The latency in microseconds that a `share` (0..1, clamped) of the samples does not exceed: the
  // upper edge of its bucket, at most Max_us(). 0 without samples.
  float Percentile_us(float share) const noexcept;
  float Max_us() const noexcept { return static_cast<float>(max_ns_) * 1e-3F; }
  std::uint32_t count() const { return count_; }
  void Clear() noexcept { *this = Histogram(); }

 private:
  static constexpr int kPerOctave = 16;
  static constexpr int kOctaves = 26;
  std::array<std::uint32_t, kPerOctave * kOctaves> buckets_{};
  std::uint32_t count_ = 0;
  std::int64_t max_ns_ = 0;
};

}  // namespace styled::runtime
