#pragma once

#include <array>
#include <cstdint>

#include "daemon/source/transport.h"
#include "model/base/realtime.h"

namespace styled::pipeline {

// A sender that begins anew while it goes on sending adds this to its session's id and is taken at
// once; any other id is another sender's.
inline constexpr std::uint64_t kSessionStep = 2;

struct SessionRules {
  std::int64_t takeover_ns = 100'000'000;      // silence after which another sender may be the
                                               // performer, or the same one count from anywhere
  std::int64_t clock_back_ns = 1'000'000'000;  // of the sender's clock; less is an old frame
};

// Whose datagrams are the performer's, and which of them are next: machine, session id, sequence,
// source time. Knows no bytes and no clock; one per performer, pipeline thread. Allocates nothing.
//
// Nobody can be silenced for good by one datagram: a session id counts only from the machine that
// began the session, and a sequence number far from the last one changes nothing while the
// performer's own go on. Where they do not (the sender restarted under the same id, or its counter
// jumped), a few in a row after a silence are taken for the new count.
// Pinned by tests/unit/daemon/session_test.cpp.
class Session {
 public:
  // Datagrams that the newest may be ahead of the one before it while the performer sends: 8.5 s of
  // 120 Hz. What was lost in a silence may be more.
  static constexpr std::uint64_t kFarAhead = 1024;
  // In a row, each a little after the one before, that make a new count.
  static constexpr int kConsistent = 5;

  enum class Arrival : std::uint8_t {
    kNext,
    kNewSession,    // the sender restarted, or another took over after silence: state starts anew
    kDuplicate,     // sequence seen before
    kReordered,     // older than the newest, and not seen before (or too old to tell)
    kRecounted,     // the same sender counts from elsewhere after silence: state starts anew
    kSecondSender,  // another session or machine while this one is alive: nothing changes
    kFarAhead,      // sequence implausibly far ahead of the newest: nothing changes
  };
  // Judges a datagram of any kind and takes note of it. `machine`: the sender's; all zeros where
  // the transport vouches for the sender itself.
  STYLED_REALTIME Arrival Admit(const source::Machine& machine, std::uint64_t session,
                                std::uint64_t sequence, std::int64_t now_ns,
                                const SessionRules& rules) noexcept;

  // Whether Admit may find the datagram new; takes no note of it.
  STYLED_REALTIME bool Plausible(const source::Machine& machine, std::uint64_t session,
                                 std::uint64_t sequence, std::int64_t now_ns,
                                 const SessionRules& rules) const noexcept;

  enum class Time : std::uint8_t {
    kNext,
    kOld,   // not after the last frame's
    kJump,  // the clock went back by more than clock_back_ns, or ahead by more than an hour
  };
  // Judges a frame's source time; after kJump the clock counts anew from this frame.
  STYLED_REALTIME Time AdmitTime(std::uint64_t source_time_ns, const SessionRules& rules) noexcept;

  // Source time since the session's first frame (or the last jump of its clock), of the last frame
  // admitted.
  std::int64_t elapsed_ns() const {
    return static_cast<std::int64_t>(last_time_ns_ - first_time_ns_);
  }
  // Sequence numbers skipped, of all sessions; no more than kFarAhead at once and, in the long run,
  // four for each that came or what the sender's rate makes of a silence: a counter that leaps
  // loses nothing.
  std::uint64_t lost() const { return lost_; }
  // Of the last datagram that was kNext or kNewSession.
  std::int64_t last_arrival_ns() const { return last_arrival_ns_; }

 private:
  STYLED_REALTIME void Start(const source::Machine& machine, std::uint64_t session,
                             std::uint64_t sequence, std::int64_t now_ns) noexcept;
  // Another sender is let in after `takeover_ns` of silence; one of another machine after three
  // intervals of a slower sender.
  STYLED_REALTIME std::int64_t Patience_ns(const source::Machine& machine,
                                           const SessionRules& rules) const noexcept;
  STYLED_REALTIME void NoteArrival(std::uint64_t skipped, std::int64_t now_ns) noexcept;
  // Whether datagrams that fit nowhere have become a count of their own.
  STYLED_REALTIME bool Recount(std::uint64_t sequence, bool silent) noexcept;

  bool live_ = false, timed_ = false;
  source::Machine machine_{};
  std::uint64_t session_ = 0;
  std::uint64_t newest_ = 0;  // sequence
  std::uint64_t seen_ = 0;    // bit i: newest_ - i has arrived
  std::uint64_t stray_ = 0;   // sequence of the last datagram that did not fit
  int strays_ = 0;            // in a row
  std::uint64_t first_time_ns_ = 0, last_time_ns_ = 0;
  std::uint64_t lost_ = 0, losable_ = kFarAhead;  // losable_: may still be counted as lost
  std::int64_t last_arrival_ns_ = 0;
  std::array<std::int64_t, 2> intervals_ns_{};  // between the last arrivals
};

}  // namespace styled::pipeline
