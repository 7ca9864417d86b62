#include "clients/stylemon/meter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace styled::stylemon {
namespace {

// The value that a fraction `share` of the values does not exceed, from ns to ms. Reorders
// `values`.
double Percentile_ms(std::vector<std::int64_t>& values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank =
      static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size())) - 1);
  const auto nth = values.begin() + std::max<std::ptrdiff_t>(rank, 0);
  std::nth_element(values.begin(), nth, values.end());
  return static_cast<double>(*nth) * 1e-6;
}

}  // namespace

void Meter::Add(std::int64_t now_ns, std::int64_t daemon_ns, std::int64_t end_ns,
                std::uint64_t missed) {
  ring_[count_++ % kSamples] = {now_ns, daemon_ns, end_ns};
  dropped_ += missed;
}

Meter::Reading Meter::Read(std::int64_t now_ns) const {
  Reading reading;
  reading.dropped = dropped_;
  std::vector<std::int64_t> daemon, end;
  std::int64_t oldest_ns = now_ns, newest_ns = 0;
  for (std::size_t i = 0; i < std::min(count_, kSamples); ++i) {
    const Sample& sample = ring_[(count_ - 1 - i) % kSamples];
    if (now_ns - sample.at_ns > window_ns_) break;
    if (i == 0) newest_ns = sample.at_ns;
    oldest_ns = sample.at_ns;
    daemon.push_back(sample.daemon_ns);
    end.push_back(sample.end_ns);
  }
  reading.frames = static_cast<int>(daemon.size());
  // Once the stream has paused for longer than its period, the span ends at the present time.
  if (reading.frames > 1) {
    const double period = static_cast<double>(newest_ns - oldest_ns) / (reading.frames - 1);
    const double silent = static_cast<double>(now_ns - newest_ns);
    const double span =
        static_cast<double>(newest_ns - oldest_ns) + std::max(0.0, silent - 4 * period);
    reading.rate_hz = span > 0 ? (reading.frames - 1) / (span * 1e-9) : 0;
  }
  reading.daemon_p50_ms = Percentile_ms(daemon, 0.50);
  reading.daemon_p99_ms = Percentile_ms(daemon, 0.99);
  reading.end_p50_ms = Percentile_ms(end, 0.50);
  reading.end_p99_ms = Percentile_ms(end, 0.99);
  return reading;
}

}  // namespace styled::stylemon
