#include "daemon/runtime/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace styled::runtime {

// The unit is 64 ns. Values are offset by 16 units, so that the first octave is linear: bucket b of
// octave o begins at (16 + b) * 2^o - 16 units.
void Histogram::Add(std::int64_t latency_ns) noexcept {
  latency_ns = std::max<std::int64_t>(latency_ns, 0);
  const auto units = static_cast<std::uint64_t>(latency_ns) / 64 + kPerOctave;
  // `units` is at least 16, whose width is 5, so that max() only guards the sign.
  const int octave = std::max(0, static_cast<int>(std::bit_width(units)) - 5);
  const auto bucket = static_cast<int>((units >> octave) - kPerOctave);
  const int index = std::min(octave * kPerOctave + bucket, kPerOctave * kOctaves - 1);
  ++buckets_[static_cast<std::size_t>(index)];
  ++count_;
  max_ns_ = std::max(max_ns_, latency_ns);
}

float Histogram::Percentile_us(float share) const noexcept {
  if (count_ == 0) return 0;
  const auto rank = static_cast<std::uint32_t>(
      std::max(1.0F, std::ceil(std::clamp(share, 0.0F, 1.0F) * static_cast<float>(count_))));
  std::uint32_t seen = 0;
  for (std::size_t i = 0; i < buckets_.size(); ++i) {
    seen += buckets_[i];
    if (seen < rank) continue;
    const auto octave = static_cast<int>(i) / kPerOctave;
    const auto bucket = static_cast<int>(i) % kPerOctave;
    const double edge_units = std::ldexp(kPerOctave + bucket + 1, octave) - kPerOctave;
    return std::min(static_cast<float>(edge_units * 0.064), Max_us());
  }
  return Max_us();
}

}  // namespace styled::runtime
