#include "daemon/standby/standby.h"

#include <algorithm>
#include <utility>

namespace styled::standby {
namespace {

constexpr std::uint32_t kVersion = 1;
// A daemon of whom nothing was heard for so long does not listen.
constexpr std::int64_t kHeard_ns = 1'000'000'000;
// The answer to Ask comes with the leader's next turn.
constexpr std::int64_t kAnswer_ns = 1'000'000'000;
// Signs of life per hold: one may be lost to a turn that takes long.
constexpr int kBeats = 5;
// However long the hold: the other daemon is to be heard within kHeard_ns, and before it leads
// alone.
constexpr std::int64_t kLongestBeat_ns = 200'000'000;
// Clocks drift apart by 20 microseconds a second and more.
constexpr std::int64_t kWindow_ns = 10'000'000'000;

const char* Name(v1::Role role) {
  switch (role) {
    case v1::ROLE_LOOKING:
      return "looking";
    case v1::ROLE_FOLLOWING:
      return "following";
    case v1::ROLE_LEADING:
      return "leading";
    case v1::ROLE_LEAVING:
      return "leaving";
    default:
      return "";
  }
}

}  // namespace

void RefuseOrder(const std::string& peer, const v1::Request& request, v1::Reply& reply) {
  reply.set_id(request.id());
  reply.set_code(v1::CODE_STANDBY);
  reply.set_reason("this daemon is the standby of " + peer +
                   ": command that one, or let this one lead (stylectl lead)");
}

Standby::Standby(std::unique_ptr<Channel> channel, const config::Standby& config,
                 std::uint64_t daemon, publish::Publisher& publisher, const runtime::Clock& clock)
    : config_(config),
      daemon_(daemon),
      beat_ns_(std::min(runtime::Nanoseconds(config.hold_s) / kBeats, kLongestBeat_ns)),
      channel_(std::move(channel)),
      clock_(clock),
      publisher_(publisher, clock),
      roles_(daemon, config.first, runtime::Nanoseconds(config.hold_s)),
      epoch_(daemon) {
  publisher_.Hold();
}

Standby::Change Standby::Note(Change change) {
  switch (change) {
    case Change::kNone:
      break;
    case Change::kFollow:
      line_ = "standby of " + config_.peer + ", which leads";
      sync_ = Sync::kNone;
      has_part_ = false;
      Refetch();
      break;
    case Change::kTakeOver:
      ++takeovers_;
      line_ = "leads from here on, in the place of " + config_.peer;
      sync_ = Sync::kNone;
      break;
    case Change::kLead:
      line_ = "leads";
      sync_ = Sync::kNone;
      break;
  }
  if (change != Change::kNone) why_not_.clear();
  return change;
}

bool Standby::Next(Step& step) {
  step = Step();
  if (!channel_->Receive(bytes_)) return false;
  if (!in_.ParseFromString(bytes_)) {
    Failed(config_.peer + " says what is no entry of a journal: is it a daemon's standby.address?");
    return true;
  }
  if (in_.version() != kVersion) {
    Failed(config_.peer + " speaks another version of the journal: both daemons must be of one");
    return true;
  }
  // A clock that no machine has: 146 years, in either direction.
  constexpr std::int64_t kMost_ns = std::int64_t{1} << 62;
  if (in_.now_ns() < 0 || in_.now_ns() > kMost_ns || in_.wall_ns() < 0) {
    Failed(config_.peer + " says impossible times");
    return true;
  }
  if (in_.daemon() == daemon_) {
    Failed("standby.peer " + config_.peer + " is this daemon itself, expected the other one");
    return true;
  }
  const std::int64_t now_ns = Now_ns();
  heard_ns_ = now_ns;
  timed_ = true;
  const bool goes_on = in_.daemon() == heard_daemon_ && in_.number() == heard_number_ + 1;
  if (in_.daemon() != heard_daemon_) best_ahead_ns_ = in_.now_ns() - now_ns;
  best_ahead_ns_ = std::max(best_ahead_ns_, in_.now_ns() - now_ns);
  heard_daemon_ = in_.daemon();
  heard_number_ = in_.number();
  if (now_ns - window_ns_ >= kWindow_ns) {
    if (sync_ == Sync::kReady && window_ns_ != 0) ahead_ns_ = best_ahead_ns_;
    best_ahead_ns_ = in_.now_ns() - now_ns;
    window_ns_ = now_ns;
  }
  const bool led = leads();
  const Change change = roles_.OnPeer({in_.daemon(), in_.role(), in_.term(), in_.first()});
  // Whoever takes the lead has everything of this daemon's journal first.
  if (led && change == Change::kFollow) SayGoodbye();
  step.change = Note(change);
  if (roles_.role() != v1::ROLE_FOLLOWING || step.change != Change::kNone) return true;
  if (!goes_on && sync_ != Sync::kAsked) Refetch();
  const bool begins = in_.has_beginning();
  if (begins || sync_ == Sync::kFetching || sync_ == Sync::kReady) step.entry = &in_;
  if (begins) ahead_ns_ = best_ahead_ns_;
  step.own_ns = in_.now_ns() - ahead_ns_;
  return true;
}

Standby::Change Standby::OnTime() {
  const std::int64_t now_ns = Now_ns();
  const Change change = Note(roles_.OnTime(now_ns, ready()));
  if (change != Change::kNone || now_ns - said_ns_ >= beat_ns_) {
    (void)NewEntry();
    Send(now_ns, clock_.base().Wall_ns());
  }
  const bool late = sync_ == Sync::kAsked && now_ns - asked_ns_ >= kAnswer_ns;
  const bool stuck = sync_ == Sync::kFetching && now_ns - asked_ns_ >= kAgain_ns;
  if (late || stuck) Refetch();
  return change;
}

std::string Standby::Wish() {
  if (leads()) return "";
  if (!ready()) {
    return "this daemon does not have the state of all performers" +
           (why_not_.empty() ? "; expected one that follows" : ": " + why_not_);
  }
  roles_.OnWish();
  (void)NewEntry();
  Send(Now_ns(), clock_.base().Wall_ns());
  return "";
}

void Standby::Leave() {
  if (leads()) SayGoodbye();
}

void Standby::SayGoodbye() {
  NewEntry().set_role(v1::ROLE_LEAVING);
  Send(Now_ns(), clock_.base().Wall_ns());
}

bool Standby::wanted() const { return leads() && timed_ && Now_ns() - heard_ns_ < kHeard_ns; }

v1::Journal& Standby::NewEntry() {
  out_.Clear();
  out_.set_role(roles_.said_role());
  return out_;
}

void Standby::Send(std::int64_t now_ns, std::int64_t wall_ns) {
  out_.set_version(kVersion);
  out_.set_daemon(daemon_);
  out_.set_epoch(epoch_);
  out_.set_term(roles_.said_term());
  out_.set_first(config_.first);
  out_.set_number(++number_);
  out_.set_now_ns(now_ns);
  out_.set_wall_ns(wall_ns);
  out_.SerializeToString(&bytes_);
  channel_->Send(std::as_bytes(std::span(bytes_)));
  said_ns_ = Now_ns();
}

bool Standby::TakeAsked() {
  if (channel_->TakeAsked()) {
    asked_ = timed_ = true;
    heard_ns_ = Now_ns();  // it listens, although what it says may not come yet
  }
  return leads() && std::exchange(asked_, false);
}

void Standby::Refetch() {
  asked_ns_ = Now_ns();
  if (sync_ != Sync::kReady) sync_ = Sync::kAsked;
  channel_->Ask();
}

void Standby::Begin(const v1::Beginning& beginning, const v1::Journal& entry) {
  ++fetched_;
  has_part_ = true;
  epoch_ = entry.epoch();
  asked_ns_ = Now_ns();
  why_not_.clear();
  awaited_ = {beginning.performers().begin(), beginning.performers().end()};
  sync_ = awaited_.empty() ? Sync::kReady : Sync::kFetching;
  last.clear();
}

void Standby::Restored(const std::string& performer) {
  awaited_.erase(performer);
  if (awaited_.empty() && sync_ == Sync::kFetching) sync_ = Sync::kReady;
}

void Standby::Failed(std::string why) {
  if (sync_ == Sync::kReady) {
    sync_ = Sync::kFetching;
    awaited_.insert("");  // nobody: it ends with the next fetch, in kAgain_ns
    asked_ns_ = Now_ns();
  }
  if (why == why_not_) return;
  why_not_ = std::move(why);
  complaint_ = "cannot stand in: " + why_not_;
}

void Standby::Compared(bool same) {
  ++compared_;
  if (same) return;
  ++different_;
  if (sync_ == Sync::kReady && Now_ns() - asked_ns_ >= kAgain_ns) Refetch();
}

void Standby::Describe(v1::StandbyState& state) const {
  state.set_role(Name(roles_.role()));
  state.set_peer(config_.peer);
  state.set_heard(timed_ && Now_ns() - heard_ns_ < kHeard_ns);
  state.set_peer_role(Name(roles_.peer().role));
  state.set_term(roles_.term());
  state.set_ready(ready());
  state.set_why_not(why_not_);
  if (why_not_.empty() && !leads() && !ready()) {
    state.set_why_not(roles_.role() == v1::ROLE_LOOKING ? "it looks whether the other one leads"
                                                        : "the state is being fetched");
  }
  state.set_compared(compared_);
  state.set_different(different_);
  state.set_fetched(fetched_);
  state.set_takeovers(takeovers_);
}

}  // namespace styled::standby
