#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "model/base/realtime.h"

namespace styled::runtime {

// Latencies since the last Clear() in fixed buckets: kPerOctave per octave, up to a minute, so that
// a percentile is at most 1 / kPerOctave too high. Larger latencies count in the last bucket. A
// full bucket (of Count) counts no further. Allocates nothing; one thread.
template <typename Count, int kPerOctave>
class BasicHistogram {
 public:
  STYLED_REALTIME void Add(std::int64_t latency_ns) noexcept {
    latency_ns = std::max<std::int64_t>(latency_ns, 0);
    // Values are offset by kPerOctave units, so that the first octave is linear: bucket b of octave
    // o begins at (kPerOctave + b) * 2^o - kPerOctave units.
    const auto units = static_cast<std::uint64_t>(latency_ns / kUnit_ns) + kPerOctave;
    // The width of `units` is at least that of kPerOctave, so that max() only guards the sign.
    const int octave = std::max(0, static_cast<int>(std::bit_width(units)) - kWidth);
    const auto bucket = static_cast<int>(units >> octave) - kPerOctave;
    const int index = std::min(octave * kPerOctave + bucket, kPerOctave * kOctaves - 1);
    Count& count = buckets_[static_cast<std::size_t>(index)];
    if (count < std::numeric_limits<Count>::max()) {
      ++count;
      ++count_;
    }
    max_ns_ = std::max(max_ns_, latency_ns);
  }
  template <typename Other>
  void Add(const BasicHistogram<Other, kPerOctave>& other) noexcept {
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      const std::uint32_t more = other.bucket(i);
      const std::uint32_t room = std::numeric_limits<Count>::max() - buckets_[i];
      buckets_[i] = static_cast<Count>(buckets_[i] + std::min(more, room));
      count_ += std::min(more, room);
    }
    max_ns_ = std::max(max_ns_, other.max_ns());
  }
  // The latency in microseconds that a `share` (0..1, clamped) of the samples does not exceed: the
  // upper edge of its bucket, at most Max_us(). 0 without samples.
  float Percentile_us(float share) const noexcept {
    if (count_ == 0) return 0;
    const auto rank = static_cast<std::uint32_t>(
        std::max(1.0, std::ceil(std::clamp(static_cast<double>(share), 0.0, 1.0) * count_)));
    std::uint32_t seen = 0;
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      seen += buckets_[i];
      if (seen < rank) continue;
      const auto octave = static_cast<int>(i) / kPerOctave;
      const auto bucket = static_cast<int>(i) % kPerOctave;
      const double edge_units = std::ldexp(kPerOctave + bucket + 1, octave) - kPerOctave;
      return std::min(static_cast<float>(edge_units * 1e-3 * kUnit_ns), Max_us());
    }
    return Max_us();
  }
  float Max_us() const noexcept { return static_cast<float>(max_ns_) * 1e-3F; }
  std::int64_t max_ns() const noexcept { return max_ns_; }
  std::uint32_t count() const noexcept { return count_; }
  std::uint32_t bucket(std::size_t i) const noexcept { return buckets_[i]; }
  void Clear() noexcept { *this = BasicHistogram(); }

 private:
  static constexpr std::int64_t kUnit_ns = 64;
  static constexpr int kWidth = std::bit_width(static_cast<unsigned>(kPerOctave));
  static_assert(std::has_single_bit(static_cast<unsigned>(kPerOctave)));
  // The number of units in a minute: kPerOctave * 2^kOctaves.
  static constexpr int kOctaves =
      std::bit_width(std::uint64_t{60'000'000'000} / kUnit_ns / kPerOctave);
  std::array<Count, static_cast<std::size_t>(kPerOctave* kOctaves)> buckets_{};
  std::uint32_t count_ = 0;
  std::int64_t max_ns_ = 0;
};

// About a second; at most 6 % too high.
using Histogram = BasicHistogram<std::uint16_t, 16>;

}  // namespace styled::runtime
