#include "daemon/decide/admission.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "daemon/runtime/clock.h"

namespace styled::decide {

bool Admission::MayChangeBody(std::int64_t now_ns) noexcept {
  const std::int64_t earned = (now_ns - body_changed_ns_) / kBodyChange_ns;
  if (earned > 0) {
    body_changes_left_ =
        static_cast<int>(std::min<std::int64_t>(kBodyChanges, body_changes_left_ + earned));
    body_changed_ns_ = now_ns;
  }
  if (body_changes_left_ == 0) return false;
  --body_changes_left_;
  return true;
}

void Admission::MarkLive(std::int64_t now_ns) noexcept {
  ++received_;
  if (last_frame_ns_ > 0) intervals_ns_ = {intervals_ns_[1], now_ns - last_frame_ns_};
  last_frame_ns_ = now_ns;
  if (!std::exchange(live_, true)) {
    since_ns_ = now_ns;
    fresh_ = true;
    rate_hz_ = 0;
  }
}

// Uses the shorter of two intervals, so that one silence does not make a rig slow.
std::int64_t Admission::StaleAfter_ns(std::int64_t stale_ns) const noexcept {
  constexpr std::int64_t kMost_ns = 10 * runtime::kSecond_ns;
  const std::int64_t period_ns = std::min(intervals_ns_[0], intervals_ns_[1]);
  return std::max(stale_ns, std::min(3 * period_ns, kMost_ns));
}

// Measures the rate between frames, not between samples: a rig at 1 Hz would have none or two
// frames in a second.
void Admission::Sample(std::uint64_t frames) noexcept {
  refusing_ = refused_ > refused_at_sample_;
  refused_at_sample_ = refused_;
  const std::int64_t span_ns = last_frame_ns_ - since_ns_;
  // After a silence, the first frame only starts the time span.
  const std::uint64_t intervals = frames - (fresh_ && frames > 0 ? 1 : 0);
  if (intervals > 0 && span_ns > 0) {
    rate_hz_ = static_cast<float>(intervals) * 1e9F / static_cast<float>(span_ns);
  }
  if (frames == 0) return;
  since_ns_ = last_frame_ns_;
  fresh_ = false;
}

void Admission::Describe(v1::PerformerStats& stats) const {
  stats.set_rate_hz(live_ ? rate_hz_ : 0);
  stats.set_received(received_);
  stats.set_lost(session.lost());
  stats.set_live(live_);
  stats.set_refused(refused_);
  if (!refusing_) return;
  const std::string_view why = runtime::Name(refused_as_);
  stats.set_refused_as(why.data(), why.size());
}

}  // namespace styled::decide
