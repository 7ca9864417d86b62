#include "daemon/standby/roles.h"

#include <algorithm>
#include <utility>

namespace styled::standby {

Roles::Change Roles::Start(Change change) {
  if (change == Change::kNone) return change;
  if (role_ == v1::ROLE_LEADING && from_nothing_ && led_ns_ < kLook_ns) {
    patience_ns_ = std::min(2 * std::max(patience_ns_, waits_ns_), kLook_ns);
  }
  silence_ns_ = led_ns_ = followed_ns_ = 0;
  const bool claimed = std::exchange(claims_, false);
  from_nothing_ = change == Change::kLead;
  if (change == Change::kFollow) {
    role_ = v1::ROLE_FOLLOWING;
    leader_ = peer_.daemon;
    term_ = peer_.term;
  } else {
    role_ = v1::ROLE_LEADING;
    term_ = claimed         ? NextTerm(term_)
            : from_nothing_ ? std::max({term_, peer_.term, std::uint64_t{1}})
                            : NextTerm(std::max(term_, peer_.term));
  }
  return change;
}

void Roles::Age(std::int64_t passed_ns) {
  const std::int64_t before_ns = led_ns_;
  led_ns_ += passed_ns;
  for (const std::int64_t age_ns : kSeniority_ns) {
    if (from_nothing_ && before_ns < age_ns && led_ns_ >= age_ns) term_ = NextTerm(term_);
  }
}

bool Roles::WinsAtStart(const Peer& peer) const {
  if (first_ != peer.first) return first_;
  return daemon_ < peer.daemon;
}

Roles::Change Roles::OnPeer(const Peer& peer) {
  if (peer.term > kMostTerm) return Change::kNone;
  const bool leads = peer.role == v1::ROLE_LEADING;
  const bool of_pair = IsOfPair(peer);
  peer_ = peer;
  if (!of_pair) peer_.term = 0;  // it belongs to the leadership of another pair
  switch (role_) {
    case v1::ROLE_FOLLOWING:
      if (peer.daemon == leader_ && leads) {
        silence_ns_ = 0;
        term_ = peer.term;
        return Change::kNone;
      }
      if (leads) return Start(of_pair ? Change::kFollow : Change::kNone);
      // The peer says goodbye, has restarted, or follows: its leadership has ended.
      silence_ns_ = std::max(waits_ns_, kLook_ns);
      return Change::kNone;
    case v1::ROLE_LEADING: {
      if (!leads || !of_pair) return Change::kNone;
      const bool gives_way = peer.term > term_ || (peer.term == term_ && peer.daemon < daemon_);
      return Start(gives_way ? Change::kFollow : Change::kNone);
    }
    default:
      looks_longer_ = leads && !of_pair;
      if (leads) return Start(of_pair ? Change::kFollow : Change::kNone);
      if (peer.role == v1::ROLE_LOOKING && WinsAtStart(peer)) return Start(Change::kLead);
      return Change::kNone;
  }
}

Roles::Change Roles::OnTime(std::int64_t now_ns, bool ready, bool whole) {
  if (!timed_) last_ns_ = now_ns;
  timed_ = true;
  const std::int64_t passed_ns = now_ns - last_ns_;
  last_ns_ = now_ns;
  if (role_ == v1::ROLE_LEADING) Age(std::max<std::int64_t>(passed_ns, 0));
  if (role_ == v1::ROLE_FOLLOWING) followed_ns_ += std::max<std::int64_t>(passed_ns, 0);
  if (followed_ns_ >= kCalm_ns) patience_ns_ = 0;
  silence_ns_ += std::clamp<std::int64_t>(passed_ns, 0, hold_ns_ / 4);
  // Without the leader's state all performers would start over, so wait until the leader is
  // certainly gone.
  const std::int64_t waits_ns = std::max({waits_ns_, patience_ns_, whole ? 0 : kLook_ns});
  if (role_ == v1::ROLE_FOLLOWING && silence_ns_ >= waits_ns) {
    return Start(ready ? Change::kTakeOver : Change::kLead);
  }
  const std::int64_t look_ns = looks_longer_ ? kLookLonger_ns : kLook_ns;
  if (role_ == v1::ROLE_LOOKING && silence_ns_ >= look_ns) return Start(Change::kLead);
  return Change::kNone;
}

}  // namespace styled::standby
