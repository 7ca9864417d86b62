#pragma once

#include <cstdint>

#include "model/base/realtime.h"

namespace styled::pipeline {

// A sender that begins anew while it goes on sending adds this to its session's id and is taken at
// once; any other id is another sender's.
inline constexpr std::uint64_t kSessionStep = 2;

struct SessionRules {
  std::int64_t takeover_ns =
      100'000'000;  // silence after which another sender may be the performer
  std::int64_t clock_back_ns = 1'000'000'000;  // of the sender's clock; less is an old frame
};

// Whose datagrams are the performer's, and which of them are next: session id, sequence, source
// time. Knows no bytes and no clock; one per performer, pipeline thread. Allocates nothing.
// Pinned by tests/unit/daemon/session_test.cpp.
class Session {
 public:
  enum class Arrival : std::uint8_t {
    kNext,
    kNewSession,    // the sender restarted, or another took over after silence: state starts anew
    kDuplicate,     // sequence seen before
    kReordered,     // older than the newest, and not seen before (or too old to tell)
    kSecondSender,  // another session while this one is alive: nothing changes
  };
  // Judges a datagram of any kind and takes note of it.
  STYLED_REALTIME Arrival Admit(std::uint64_t session, std::uint64_t sequence, std::int64_t now_ns,
                                const SessionRules& rules) noexcept;

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
  // Sequence numbers skipped, of all sessions.
  std::uint64_t lost() const { return lost_; }
  std::int64_t last_arrival_ns() const { return last_arrival_ns_; }

 private:
  bool live_ = false, timed_ = false;
  std::uint64_t session_ = 0;
  std::uint64_t newest_ = 0;  // sequence
  std::uint64_t seen_ = 0;    // bit i: newest_ - i has arrived
  std::uint64_t first_time_ns_ = 0, last_time_ns_ = 0;
  std::uint64_t lost_ = 0;
  std::int64_t last_arrival_ns_ = 0;
};

}  // namespace styled::pipeline
