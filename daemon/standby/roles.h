#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/styled/v1/journal.pb.h"

namespace styled::standby {

// The content of the peer's last message.
struct Peer {
  std::uint64_t daemon = 0;  // random number of its start; 0: no message yet
  v1::Role role = v1::ROLE_NONE;
  std::uint64_t term = 0;
  bool first = false;
  std::uint64_t hears = 0;  // `daemon` of the daemon that it receives itself; 0: none
};

// Decides which of two daemons leads. It reads no clock and sends nothing: the caller passes in the
// peer's messages and the time. One thread.
//
// It fails open: a daemon that receives nothing leads. If both lead because the connection was
// interrupted, the one with the higher term remains the leader. A leader that receives a third
// daemon belongs to another pair: this daemon neither follows it nor yields to it. Pinned by
// tests/unit/standby/who_leads_test.cpp.
class Roles {
 public:
  enum class Change : std::uint8_t {
    kNone,
    kLead,      // without the peer's state
    kTakeOver,  // continues with the peer's state
    kFollow,    // this daemon's state is void: the peer's state replaces it
  };
  // Time for which a starting daemon waits for a leader. ZeroMQ connects within a few milliseconds,
  // and tries again every 100 ms.
  static constexpr std::int64_t kLook_ns = 1'000'000'000;
  // The same if a leader is present that receives another daemon. That other daemon may be the
  // previous start of this one, which the leader forgets after a second of silence.
  static constexpr std::int64_t kLookLonger_ns = 2'500'000'000;
  // Heartbeats come at least every 200 ms, however long the hold is (standby.cpp); one may be lost.
  static constexpr std::int64_t kLongestWait_ns = 500'000'000;
  // A daemon that led for less than kLook_ns, because its leader had only stalled, waits twice as
  // long the next time, up to kLook_ns, until it has followed for this time. Without it the roles
  // change with each pause of a busy machine.
  static constexpr std::int64_t kCalm_ns = 10'000'000'000;
  // Beyond any real term: a takeover every 20 ms would reach it after three years. Peers with
  // higher terms are ignored, so that the term cannot wrap around.
  static constexpr std::uint64_t kMostTerm = std::uint64_t{1} << 32U;

  // `daemon`: random, not 0. `first`: leads if both have just started. `hold_ns`: silence of the
  // leader after which the standby takes over.
  Roles(std::uint64_t daemon, bool first, std::int64_t hold_ns)
      : daemon_(daemon), first_(first), hold_ns_(hold_ns) {}

  // Call for each message of the peer.
  Change OnPeer(const Peer& peer);
  // Whether the peer may belong to this daemon's pair: it does not receive a third daemon.
  bool IsOfPair(const Peer& peer) const { return peer.hears == 0 || peer.hears == daemon_; }
  // The peer's hold, which sets the interval of its heartbeats. If it is longer than this daemon's
  // own, this daemon waits that long, too, up to kLongestWait_ns.
  void SetHoldOfPeer(std::int64_t hold_ns) {
    waits_ns_ = std::max(hold_ns_, std::min(hold_ns, kLongestWait_ns));
  }
  // Call at least every hold_ns / 4. `ready`: this daemon can continue exactly as the leader.
  // `whole`: it has the leader's state, even if its configuration differs; otherwise it waits for
  // kLook_ns at least. If the calls pause for longer, only hold_ns / 4 counts as silence of the
  // peer: it was this daemon that was interrupted.
  Change OnTime(std::int64_t now_ns, bool ready, bool whole);
  // Requests leadership (`stylectl lead`). This daemon announces that it leads in the next term.
  // The leader first sends its remaining entries and then a goodbye. Call only while this daemon
  // follows and is ready.
  void RequestLead() { claims_ = true; }

  v1::Role role() const { return role_; }
  std::uint64_t term() const { return term_; }
  // The role and term announced to the peer.
  v1::Role advertised_role() const { return claims_ ? v1::ROLE_LEADING : role_; }
  std::uint64_t advertised_term() const { return claims_ ? NextTerm(term_) : term_; }
  const Peer& peer() const { return peer_; }
  std::uint64_t leader() const { return leader_; }  // the daemon that it follows
  std::int64_t silence_ns() const { return silence_ns_; }
  std::int64_t hold_ns() const { return hold_ns_; }

 private:
  // A daemon that leads without the peer's state gains a term after each of these durations. Of two
  // leaders that never received each other, the one with the longer running show therefore remains.
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
  std::uint64_t term_ = 0;    // of the known leadership
  std::uint64_t leader_ = 0;  // the daemon that it follows
  Peer peer_;
  std::int64_t last_ns_ = 0, silence_ns_ = 0;
  bool timed_ = false;
  bool claims_ = false;  // it has requested leadership, and the leader has not said goodbye yet
  bool from_nothing_ = false;
  bool looks_longer_ = false;
  std::int64_t led_ns_ = 0, followed_ns_ = 0;
  std::int64_t patience_ns_ = 0;  // the least silence of the leader before the next change of roles
};

}  // namespace styled::standby
