#include "daemon/pipeline/session.h"

namespace styled::pipeline {
namespace {
constexpr std::uint64_t kWindow = 64;
constexpr std::uint64_t kHour_ns = 3600ULL * 1'000'000'000;
}  // namespace

Session::Arrival Session::Admit(std::uint64_t session, std::uint64_t sequence, std::int64_t now_ns,
                                const SessionRules& rules) noexcept {
  if (!live_ || session != session_) {
    const bool anew = session == session_ + kSessionStep;
    if (live_ && !anew && now_ns - last_arrival_ns_ < rules.takeover_ns) {
      return Arrival::kSecondSender;
    }
    live_ = true;
    timed_ = false;
    session_ = session;
    newest_ = sequence;
    seen_ = 1;
    last_arrival_ns_ = now_ns;
    return Arrival::kNewSession;
  }
  last_arrival_ns_ = now_ns;
  if (sequence > newest_) {
    const std::uint64_t step = sequence - newest_;
    lost_ += step - 1;
    seen_ = step >= kWindow ? 1 : (seen_ << step) | 1U;
    newest_ = sequence;
    return Arrival::kNext;
  }
  const std::uint64_t age = newest_ - sequence;
  if (age >= kWindow) return Arrival::kReordered;
  const std::uint64_t bit = 1ULL << age;
  if ((seen_ & bit) != 0) return Arrival::kDuplicate;
  seen_ |= bit;
  return Arrival::kReordered;
}

Session::Time Session::AdmitTime(std::uint64_t source_time_ns, const SessionRules& rules) noexcept {
  if (!timed_) {
    timed_ = true;
    first_time_ns_ = last_time_ns_ = source_time_ns;
    return Time::kNext;
  }
  if (source_time_ns > last_time_ns_ && source_time_ns - last_time_ns_ <= kHour_ns) {
    last_time_ns_ = source_time_ns;
    return Time::kNext;
  }
  const auto back_ns = static_cast<std::uint64_t>(rules.clock_back_ns);
  if (source_time_ns <= last_time_ns_ && last_time_ns_ - source_time_ns <= back_ns) {
    return Time::kOld;
  }
  first_time_ns_ = last_time_ns_ = source_time_ns;
  return Time::kJump;
}

}  // namespace styled::pipeline
