#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/styled/v1/journal.pb.h"

namespace styled::standby {

// What a daemon knows of the other one by its last message.
struct Peer {
  std::uint64_t daemon = 0;  // which start of it; 0: never heard
  v1::Role role = v1::ROLE_NONE;
  std::uint64_t term = 0;
  bool first = false;
  std::uint64_t hears = 0;  // whom it hears itself, as `daemon`; 0: nobody
};

// Decides which of two daemons leads. It reads no clock and sends nothing: the caller tells it what
// the other daemon said and how time passes. One thread.
//
// It fails open: a daemon that hears nothing leads. Where both lead, since neither heard the other
// for a while, the one of the higher term stays. A leader that hears a third daemon belongs to
// another pair: this daemon neither follows it nor gives way to it. Pinned by
// tests/unit/standby/who_leads_test.cpp.
class Roles {
 public:
  enum class Change : std::uint8_t {
    kNone,
    kLead,      // from nothing: it has no state of the other's
    kTakeOver,  // it goes on with the other's state
    kFollow,    // whatever it has is void: the other's state counts
  };
  // A daemon that starts listens for so long whether the other one leads. ZeroMQ connects within a
  // few milliseconds, and tries again every 100 ms.
  static constexpr std::int64_t kLook_ns = 1'000'000'000;
  // The same while a leader is there that hears another daemon. That may be the last start of this
  // one: it is forgotten after a second of silence.
  static constexpr std::int64_t kLookLonger_ns = 2'500'000'000;
  // A sign of life comes every 200 ms, however long the hold is (standby.cpp); one may be lost.
  static constexpr std::int64_t kLongestWait_ns = 500'000'000;
  // No pair comes so far: a takeover every 20 ms reaches it after three years. Peers of higher
  // terms are ignored, so that a term cannot wrap around.
  static constexpr std::uint64_t kMostTerm = std::uint64_t{1} << 32U;

  // `daemon`: random, not 0. `first`: it leads where both have just started. `hold_ns`: silence
  // after which the standby goes on alone.
  Roles(std::uint64_t daemon, bool first, std::int64_t hold_ns)
      : daemon_(daemon), first_(first), hold_ns_(hold_ns) {}

  // A message of the other daemon came.
  Change OnPeer(const Peer& peer);
  // Whether the other daemon may be this one's: it does not hear a third one.
  bool IsOfPair(const Peer& peer) const { return peer.hears == 0 || peer.hears == daemon_; }
  // The other daemon's hold, by which it paces its signs of life: this one waits as long, up to
  // kLongestWait_ns, if that is longer than its own.
  void SetHoldOfPeer(std::int64_t hold_ns) {
    waits_ns_ = std::max(hold_ns_, std::min(hold_ns, kLongestWait_ns));
  }
  // Call at least every hold_ns / 4. `ready`: it would go on as the leader does. `whole`: it has
  // the leader's state, however it is set up itself; without it it waits for kLook_ns at least. Of
  // a longer pause only that much counts as the other's silence: it was this daemon that stood
  // still.
  Change OnTime(std::int64_t now_ns, bool ready, bool whole);
  // Somebody wants this daemon to lead. It says that it leads in the next term; what the leader
  // still has to say comes first: it ends with a goodbye. Only while it follows and is ready.
  void RequestLead() { claims_ = true; }

  v1::Role role() const { return role_; }
  std::uint64_t term() const { return term_; }
  // As the other daemon is told.
  v1::Role advertised_role() const { return claims_ ? v1::ROLE_LEADING : role_; }
  std::uint64_t advertised_term() const { return claims_ ? NextTerm(term_) : term_; }
  const Peer& peer() const { return peer_; }
  std::uint64_t leader() const { return leader_; }  // whom it follows, while it does
  std::int64_t silence_ns() const { return silence_ns_; }
  std::int64_t hold_ns() const { return hold_ns_; }

 private:
  // A daemon that leads from nothing gains a term when it has done so for each of these times: of
  // two that never heard of each other the one with the longer show stays.
  static constexpr std::int64_t kSeniority_ns[] = {5'000'000'000, 60'000'000'000, 600'000'000'000,
                                                   3'600'000'000'000};

  static std::uint64_t NextTerm(std::uint64_t term) { return std::min(term + 1, kMostTerm); }
  Change Start(Change change);
  void Age(std::int64_t passed_ns);
  bool WinsAtStart(const Peer& peer) const;

  const std::uint64_t daemon_;
  const bool first_;
  const std::int64_t hold_ns_;
  std::int64_t waits_ns_ = hold_ns_;
  v1::Role role_ = v1::ROLE_LOOKING;
  std::uint64_t term_ = 0;    // of the leadership that it knows
  std::uint64_t leader_ = 0;  // whom it follows
  Peer peer_;
  std::int64_t last_ns_ = 0, silence_ns_ = 0;
  bool timed_ = false;
  bool claims_ = false;  // it wants to lead, and the leader has not said goodbye yet
  bool from_nothing_ = false;
  bool looks_longer_ = false;
  std::int64_t led_ns_ = 0;
};

}  // namespace styled::standby
