#include "daemon/decide/session.h"

#include <algorithm>

namespace styled::decide {
namespace {
constexpr std::uint64_t kWindow = 64;
constexpr std::uint64_t kHour_ns = 3600ULL * 1'000'000'000;
// Shortest interval between two datagrams of one performer.
constexpr std::uint64_t kFastest_ns = 1'000'000;
// Each arrived datagram permits so many counted losses: even an overload loses less than half.
constexpr std::uint64_t kLosable = 4;
constexpr std::int64_t kLongestPatience_ns = 10'000'000'000;
// A longer session starts its time anew, long before the counter overflows: 146 years.
constexpr std::uint64_t kLongestSession_ns = 1ULL << 62U;

// The largest plausible step of the sequence after such a silence.
std::uint64_t MostAhead(std::int64_t silence_ns) noexcept {
  return Session::kFarAhead +
         static_cast<std::uint64_t>(std::max<std::int64_t>(0, silence_ns)) / kFastest_ns;
}
}  // namespace

void Session::Start(const source::Machine& machine, std::uint64_t session, std::uint64_t sequence,
                    std::int64_t now_ns) noexcept {
  live_ = true;
  timed_ = false;
  machine_ = machine;
  session_ = session;
  newest_ = sequence;
  seen_ = 1;
  strays_ = 0;
  losable_ = kFarAhead;
  intervals_ns_ = {};
  last_arrival_ns_ = now_ns;
}

// Uses the shorter of two intervals, so that one silence does not make a sender slow.
std::int64_t Session::TakeoverAfter_ns(const source::Machine& machine,
                                       const SessionRules& rules) const noexcept {
  if (machine == machine_) return rules.takeover_ns;
  const std::int64_t interval_ns = std::min(intervals_ns_[0], intervals_ns_[1]);
  return std::max(rules.takeover_ns, std::min(3 * interval_ns, kLongestPatience_ns));
}

void Session::NoteArrival(std::uint64_t skipped, std::int64_t now_ns) noexcept {
  const std::int64_t silence_ns = std::max<std::int64_t>(0, now_ns - last_arrival_ns_);
  const auto usual_ns = static_cast<std::uint64_t>(std::min(intervals_ns_[0], intervals_ns_[1]));
  // Each arrival permits more countable losses: kLosable, or as many as the silence before it
  // explains at the sender's usual rate.
  losable_ +=
      std::max(kLosable, static_cast<std::uint64_t>(silence_ns) / std::max(usual_ns, kFastest_ns));
  const std::uint64_t lost = std::min(skipped, losable_);
  lost_ += lost;
  losable_ = std::min(losable_ - lost, kFarAhead);
  intervals_ns_ = {intervals_ns_[1], silence_ns};
  last_arrival_ns_ = now_ns;
}

Session::Arrival Session::Admit(const source::Machine& machine, std::uint64_t session,
                                std::uint64_t sequence, std::int64_t now_ns,
                                const SessionRules& rules) noexcept {
  const std::int64_t silence_ns = now_ns - last_arrival_ns_;
  const bool silent = silence_ns >= rules.takeover_ns;
  if (!live_ || session != session_ || machine != machine_) {
    const bool anew = session == session_ + kSessionStep && machine == machine_;
    if (live_ && !anew && silence_ns < TakeoverAfter_ns(machine, rules))
      return Arrival::kSecondSender;
    Start(machine, session, sequence, now_ns);
    return Arrival::kNewSession;
  }
  if (sequence > newest_) {
    const std::uint64_t step = sequence - newest_;
    if (step > MostAhead(silence_ns)) {
      if (!Recount(sequence, silent)) return Arrival::kFarAhead;
      Start(machine, session, sequence, now_ns);
      return Arrival::kRecounted;
    }
    // Bit i of seen_ stands for newest_ - i: shift by the step, then set bit 0 for this datagram.
    seen_ = step >= kWindow ? 1 : (seen_ << step) | 1U;
    newest_ = sequence;
    strays_ = 0;
    NoteArrival(step - 1, now_ns);
    return Arrival::kNext;
  }
  if (Recount(sequence, silent)) {
    Start(machine, session, sequence, now_ns);
    return Arrival::kRecounted;
  }
  const std::uint64_t age = newest_ - sequence;
  if (age >= kWindow) return Arrival::kReordered;
  const std::uint64_t bit = 1ULL << age;
  if ((seen_ & bit) != 0) return Arrival::kDuplicate;
  seen_ |= bit;
  return Arrival::kReordered;
}

bool Session::Plausible(const source::Machine& machine, std::uint64_t session,
                        std::uint64_t sequence, std::int64_t now_ns,
                        const SessionRules& rules) const noexcept {
  const std::int64_t silence_ns = now_ns - last_arrival_ns_;
  if (!live_ || silence_ns >= TakeoverAfter_ns(machine, rules)) return true;
  if (machine != machine_) return false;
  if (session != session_) return session == session_ + kSessionStep;
  return sequence > newest_ && sequence - newest_ <= MostAhead(silence_ns);
}

bool Session::Recount(std::uint64_t sequence, bool silent) noexcept {
  const bool follows = strays_ > 0 && sequence > stray_ && sequence - stray_ <= kWindow;
  strays_ = follows ? std::min(strays_ + 1, kConsistent) : 1;
  stray_ = sequence;
  return silent && strays_ >= kConsistent;
}

Session::Time Session::AdmitTime(std::uint64_t source_time_ns, const SessionRules& rules) noexcept {
  if (!timed_) {
    timed_ = true;
    first_time_ns_ = last_time_ns_ = source_time_ns;
    return Time::kNext;
  }
  if (source_time_ns > last_time_ns_ && source_time_ns - last_time_ns_ <= kHour_ns &&
      source_time_ns - first_time_ns_ <= kLongestSession_ns) {
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

}  // namespace styled::decide
