#pragma once

#include <array>
#include <cstdint>

#include "daemon/source/transport.h"
#include "model/base/checkpoint.h"
#include "model/base/realtime.h"

namespace styled::decide {

// A sender that restarts its stream while it keeps sending adds this to its session's id, and is
// accepted at once. Any other id is treated as another sender's.
inline constexpr std::uint64_t kSessionStep = 2;

struct SessionRules {
  // Silence after which another sender may become the performer, or the same one may continue from
  // any sequence number.
  std::int64_t takeover_ns = 100'000'000;
  // A sender's clock that goes back further starts a new session; a smaller step is an old frame.
  std::int64_t clock_back_ns = 1'000'000'000;
};

// Decides which datagrams belong to a performer and which of them are next, by machine, session id,
// sequence and source time. It reads no bytes and no clock. One per performer, pipeline thread.
// Allocates nothing.
//
// No single datagram can silence a performer for good. A session id counts only from the machine
// that began the session. A sequence number far from the last one changes nothing while the
// performer's own numbers continue. If they do not (the sender restarted under the same id, or its
// counter jumped), a few consecutive numbers after a silence are accepted as the new count. Pinned
// by tests/unit/daemon/decide/session_test.cpp.
class Session {
 public:
  // The largest step of the sequence while the performer sends: 8.5 s at 120 Hz. After a silence
  // the step may be larger.
  static constexpr std::uint64_t kFarAhead = 1024;
  // Number of consecutive datagrams, each a little after the one before, that start a new count.
  static constexpr int kConsistent = 5;

  enum class Arrival : std::uint8_t {
    kNext,
    kNewSession,    // the sender restarted, or another took over after silence: reset the state
    kDuplicate,     // sequence seen before
    kReordered,     // older than the newest, and not seen before (or too old to tell)
    kRecounted,     // the same sender continues from another number after silence: reset the state
    kSecondSender,  // another session or machine while this one is live: nothing changes
    kFarAhead,      // sequence implausibly far ahead of the newest: nothing changes
  };
  // Judges a datagram of any kind and updates the state. `machine`: the sender's; all zeros if the
  // transport itself distinguishes its senders.
  STYLED_REALTIME Arrival Admit(const source::Machine& machine, std::uint64_t session,
                                std::uint64_t sequence, std::int64_t now_ns,
                                const SessionRules& rules) noexcept;

  // Whether Admit might accept the datagram; changes nothing.
  STYLED_REALTIME bool Plausible(const source::Machine& machine, std::uint64_t session,
                                 std::uint64_t sequence, std::int64_t now_ns,
                                 const SessionRules& rules) const noexcept;

  enum class Time : std::uint8_t {
    kNext,
    kOld,   // not after the last frame's
    kJump,  // the clock went back by more than clock_back_ns, or forward by more than an hour
  };
  // Judges a frame's source time. After kJump, time is counted from this frame.
  STYLED_REALTIME Time AdmitTime(std::uint64_t source_time_ns, const SessionRules& rules) noexcept;

  // From now on the performer's datagrams have other numbers: they come from another machine, or
  // another program assigned the numbers. The arguments are the new numbers of the last accepted
  // frame. The state continues.
  STYLED_REALTIME void GoOnAs(const source::Machine& machine, std::uint64_t session,
                              std::uint64_t sequence, std::uint64_t source_time_ns) noexcept {
    machine_ = machine;
    session_ = session;
    newest_ = stray_ = sequence;
    seen_ = 1;
    strays_ = 0;
    first_time_ns_ = source_time_ns - (last_time_ns_ - first_time_ns_);
    last_time_ns_ = source_time_ns;
  }

  // Source time of the last admitted frame since the session's first frame, or since the last jump
  // of its clock.
  std::int64_t elapsed_ns() const {
    return static_cast<std::int64_t>(last_time_ns_ - first_time_ns_);
  }
  // Sequence numbers skipped, over all sessions. Limited to kFarAhead at once and, in the long run,
  // to four per arrived datagram or what the sender's rate explains by a silence, so that a counter
  // that jumps is not counted as loss.
  std::uint64_t lost() const { return lost_; }
  // Arrival of the last datagram that was kNext, kNewSession or kRecounted.
  std::int64_t last_arrival_ns() const { return last_arrival_ns_; }

  // See model/base/checkpoint.h. After a restore the last datagram counts as arrived at `now_ns`,
  // because the clocks of two daemons are unrelated.
  STYLED_REALTIME void Carry(Checkpoint& c, std::int64_t now_ns) noexcept {
    c(live_, timed_, machine_, session_, newest_, seen_, stray_);
    c.Within(strays_, 0, kConsistent);
    c(first_time_ns_, last_time_ns_, lost_, losable_);
    if (last_time_ns_ - first_time_ns_ > kLongest_ns) c.Refuse();  // a step back is huge, too
    for (std::int64_t& interval_ns : intervals_ns_) c.Time(interval_ns);
    if (c.reads()) last_arrival_ns_ = now_ns;
  }

 private:
  static constexpr std::uint64_t kLongest_ns = std::uint64_t{1} << 61U;  // 73 years

  STYLED_REALTIME void Start(const source::Machine& machine, std::uint64_t session,
                             std::uint64_t sequence, std::int64_t now_ns) noexcept;
  // Silence after which another sender is admitted: `takeover_ns`, or, for a sender on another
  // machine, three intervals of a slower sender.
  STYLED_REALTIME std::int64_t TakeoverAfter_ns(const source::Machine& machine,
                                                const SessionRules& rules) const noexcept;
  STYLED_REALTIME void NoteArrival(std::uint64_t skipped, std::int64_t now_ns) noexcept;
  // Whether datagrams that do not fit have formed a new count.
  STYLED_REALTIME bool Recount(std::uint64_t sequence, bool silent) noexcept;

  bool live_ = false, timed_ = false;
  source::Machine machine_{};
  std::uint64_t session_ = 0;
  std::uint64_t newest_ = 0;  // sequence
  std::uint64_t seen_ = 0;    // bit i: newest_ - i has arrived
  std::uint64_t stray_ = 0;   // sequence of the last datagram that did not fit
  int strays_ = 0;            // number of those in a row
  std::uint64_t first_time_ns_ = 0, last_time_ns_ = 0;
  std::uint64_t lost_ = 0, losable_ = kFarAhead;  // losable_: how many may still be counted as lost
  std::int64_t last_arrival_ns_ = 0;
  std::array<std::int64_t, 2> intervals_ns_{};  // between the last arrivals
};

}  // namespace styled::decide
