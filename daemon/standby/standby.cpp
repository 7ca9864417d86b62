#include "daemon/standby/standby.h"

#include <algorithm>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include "daemon/looks/refusal.h"
#include "model/base/text.h"

namespace styled::standby {
namespace {

constexpr std::uint32_t kVersion = 4;
// Above any real clock or message count: 146 years in nanoseconds.
constexpr std::int64_t kMostTime_ns = std::int64_t{1} << 62U;
constexpr std::uint64_t kMostNumber = std::uint64_t{1} << 62U;
// Accepted range of the peer's hold: wider than the allowed values of hold_ms, 20 ms to 5 s, which
// are rounded.
constexpr std::uint64_t kLeastHold_ns = 10'000'000, kMostHold_ns = 10'000'000'000;
// A peer that was silent for this long does not count as connected.
constexpr std::int64_t kHeard_ns = 1'000'000'000;
// Interval at which this daemon connects again while the peer is silent.
constexpr std::int64_t kReconnect_ns = 2'000'000'000;
// Longest wait for the answer to Ask, which comes with the leader's next turn.
constexpr std::int64_t kAnswer_ns = 1'000'000'000;
// Heartbeats per hold: one may be missing because of a long turn.
constexpr int kBeats = 5;
// Longest interval of heartbeats, whatever the hold. The peer must be heard within kHeard_ns, and
// before it takes over (Roles::kLongestWait_ns).
constexpr std::int64_t kLongestBeat_ns = 200'000'000;
// The clock difference is measured again in each such window, because clocks drift apart by 20
// microseconds a second and more.
constexpr std::int64_t kWindow_ns = 10'000'000'000;
// The whole state is sent this many times in succession, which a standby needs that has just
// started and imports styles. After that it is sent once per kStateEvery_ns, which limits the cost
// of a client that keeps subscribing.
constexpr int kStatesAtOnce = 3;
constexpr std::int64_t kStateEvery_ns = 1'000'000'000;
// A standby that connects and requests the state causes two per second.
constexpr int kUsualAsks = 10;
constexpr std::int64_t kSetupEvery_ns = 1'000'000'000;
constexpr const char* kOtherPair =
    "that daemon receives a third one: expected its standby.peer to be this daemon's "
    "standby.address";
constexpr std::size_t kQuoted = 80;  // shown bytes of a value from the peer
// Limit of each list in a state's messages: a leader has at most 1,088 style places and 1,024
// performers. A message of 16 MiB could name millions, each a node in the set of awaited parts.
constexpr int kMostListed = 2048;
constexpr std::size_t kMostDiffers = 16, kShownDiffers = 3;
// Names in awaited_ besides styles, "*" and performer ids, which contain a dot.
constexpr const char* kSettings = "settings";
constexpr const char* kNobody = "";

std::string OfStyle(const std::string& name) { return "style " + name; }
std::string OfFading(std::uint32_t place) { return "style in place " + std::to_string(place); }

// The content of an entry, for messages.
std::string TitleOf(const v1::Journal& entry) {
  switch (entry.what_case()) {
    case v1::Journal::kBatch:
      return "frames of source " + Printable(entry.batch().name(), kQuoted);
    case v1::Journal::kRequest:
      return "a request for " + Printable(entry.request().performer(), kQuoted);
    case v1::Journal::kCheckpoint:
      return "the state of " + Printable(entry.checkpoint().performer(), kQuoted);
    case v1::Journal::kStyle:
      return "style \"" + Printable(entry.style().name(), kQuoted) + "\"";
    case v1::Journal::kSettings:
      return "settings of performers";
    case v1::Journal::kBeginning:
      return "the list of made styles";
    default:
      return "a message";
  }
}

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

Status OrderRefused(const std::string& peer) {
  return pipeline::Refused(v1::CODE_STANDBY,
                           "this daemon is the standby of " + peer +
                               ": send the request there, or let this daemon lead (stylectl lead)");
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
      epoch_(daemon),
      setup_sent_ns_(clock.Now_ns() - kSetupEvery_ns),
      reconnected_ns_(clock.Now_ns()),
      next_state_ns_(clock.Now_ns() - kStateEvery_ns * (kStatesAtOnce - 1)) {
  publisher_.Hold();
}

void Standby::SetSetup(v1::Setup setup) {
  setup_ = std::move(setup);
  v1::Setting& hold = *setup_.add_settings();
  hold.set_name("standby.hold_ms");
  hold.set_value(NumberText(config_.hold_s * 1000, 3));
  setup_sent_ns_ = Now_ns() - kSetupEvery_ns;
  CompareSetups();
}

void Standby::CompareSetups() {
  const std::vector<std::string> before = std::exchange(differs_, {});
  if (!peer_setup_known_) return;
  std::multimap<std::string_view, std::string_view> there;  // cues may share a name; in their order
  for (const v1::Setting& setting : peer_setup_.settings()) {
    there.emplace(setting.name(), setting.value());
  }
  const auto add = [this](std::string_view name, const std::string& how) {
    if (differs_.size() < kMostDiffers) differs_.push_back(Printable(name, kQuoted) + ": " + how);
  };
  for (const v1::Setting& here : setup_.settings()) {
    const auto found = there.lower_bound(here.name());
    const std::string value = Printable(here.value(), kQuoted) + " here, ";
    if (found == there.end() || found->first != here.name()) {
      add(here.name(), value + "none there");
      continue;
    }
    if (found->second != here.value()) {
      add(here.name(), value + Printable(found->second, kQuoted) + " there");
    }
    there.erase(found);
  }
  for (const auto& [name, value] : there) {
    add(name, "none here, " + Printable(value, kQuoted) + " there");
  }
  if (!differs_.empty() && differs_ != before && roles_.role() == v1::ROLE_FOLLOWING) {
    complaint_ = "cannot stand in: " + DiffersText();
  }
}

std::string Standby::DiffersText() const {
  std::string text = "its configuration differs from the leader's: ";
  for (std::size_t i = 0; i < std::min(differs_.size(), kShownDiffers); ++i) {
    text += (i == 0 ? "" : "; ") + differs_[i];
  }
  if (differs_.size() > kShownDiffers) {
    text += "; and " + std::to_string(differs_.size() - kShownDiffers) + " more";
  }
  return text;
}

Standby::Change Standby::Note(Change change) {
  switch (change) {
    case Change::kNone:
      break;
    case Change::kFollow:
      line_ = {"standby of " + config_.peer + ", which leads"};
      sync_ = Sync::kNone;
      has_part_ = asking_ = gap_ = false;
      apart_of_last_.reset();
      Refetch();
      break;
    case Change::kTakeOver:
      ++takeovers_;
      line_ = {"leads from now on, in place of " + config_.peer, true};
      sync_ = Sync::kNone;
      break;
    case Change::kLead: {
      const std::string why = WhyNot();
      line_ = sync_ == Sync::kNone ? Line{"leads"}
                                   : Line{"leads, although it was not ready: " + why, true};
      sync_ = Sync::kNone;
      break;
    }
  }
  if (change != Change::kNone) why_not_.clear();
  return change;
}

Status Standby::Read() {
  if (!in_.ParseFromString(bytes_) || bytes_.empty()) {
    return Status::Error("it is not an entry of a journal: is it a daemon's standby.address?");
  }
  if (in_.version() != kVersion) {
    return Status::Error("its version of the journal is " + std::to_string(in_.version()) +
                         ", expected " + std::to_string(kVersion));
  }
  if (in_.now_ns() < 0 || in_.now_ns() > kMostTime_ns || in_.wall_ns() < 0 ||
      in_.wall_ns() > kMostTime_ns) {
    return Status::Error("its times are impossible");
  }
  if (in_.daemon() == daemon_) {
    return Status::Error("standby.peer is this daemon itself, expected the other daemon");
  }
  if (in_.daemon() == 0 || in_.number() == 0 || in_.number() > kMostNumber) {
    return Status::Error("its sender or number is impossible");
  }
  if (in_.role() < v1::ROLE_LOOKING || in_.role() > v1::ROLE_LEAVING) {
    return Status::Error("its role is " + std::to_string(in_.role()) + ", which no daemon has");
  }
  if (in_.term() > Roles::kMostTerm) {
    return Status::Error("its term is " + std::to_string(in_.term()) + ", expected at most " +
                         std::to_string(Roles::kMostTerm));
  }
  const v1::Beginning& beginning = in_.beginning();
  for (const int listed :
       {beginning.styles_size(), beginning.places_size(), beginning.retired_size(),
        beginning.fading_size(), in_.settings().performers_size()}) {
    if (listed > kMostListed) {
      return Status::Error("it lists " + std::to_string(listed) +
                           " styles or performers, expected at most " +
                           std::to_string(kMostListed));
    }
  }
  if (in_.hold_ns() < kLeastHold_ns || in_.hold_ns() > kMostHold_ns) {
    return Status::Error("its hold_ms is impossible");
  }
  return Status::Ok();
}

// The message may come from any program at the peer's address, so it has no effect on roles or
// state.
void Standby::Refuse(std::string why) {
  ++refused_;
  refused_why_ = std::move(why);
  complaint_ = "a message from " + config_.peer + " is ignored: " + refused_why_;
}

// The peer may still have received the previous start of this daemon, so only a lasting mismatch is
// reported.
void Standby::NotePair(const Peer& peer, std::int64_t now_ns) {
  if (roles_.IsOfPair(peer)) {
    stranger_ns_ = 0;
  } else if (stranger_ns_ == 0) {
    stranger_ns_ = now_ns;
  } else if (now_ns - stranger_ns_ >= Roles::kLookLonger_ns) {
    Refuse(kOtherPair);
  }
}

void Standby::MeasureClock(std::int64_t now_ns) {
  if (in_.daemon() != heard_daemon_) best_ahead_ns_ = in_.now_ns() - now_ns;
  best_ahead_ns_ = std::max(best_ahead_ns_, in_.now_ns() - now_ns);
  if (now_ns - window_ns_ < kWindow_ns) return;
  if (sync_ == Sync::kReady && window_ns_ != 0) ahead_ns_ = best_ahead_ns_;
  best_ahead_ns_ = in_.now_ns() - now_ns;
  window_ns_ = now_ns;
}

bool Standby::Next(Step& step) {
  step = Step();
  if (!channel_->Receive(bytes_)) return false;
  if (const Status status = Read(); !status.ok()) {
    Refuse(status.message());
    return true;
  }
  const std::int64_t now_ns = Now_ns();
  heard_ns_ = listened_ns_ = now_ns;
  heard_ = listens_ = true;
  MeasureClock(now_ns);
  const bool goes_on = in_.daemon() == heard_daemon_ && in_.number() == heard_number_ + 1;
  if (in_.daemon() != heard_daemon_) peer_setup_known_ = false;
  heard_daemon_ = in_.daemon();
  heard_number_ = in_.number();
  if (in_.has_setup()) {
    peer_setup_known_ = true;
    peer_setup_.Swap(in_.mutable_setup());
    CompareSetups();
  }
  const Peer peer{in_.daemon(), in_.role(), in_.term(), in_.first(), in_.hears()};
  NotePair(peer, now_ns);
  if (roles_.IsOfPair(peer)) roles_.SetHoldOfPeer(static_cast<std::int64_t>(in_.hold_ns()));
  const bool led = leads();
  const Change change = roles_.OnPeer(peer);
  // A daemon that takes the lead first receives this daemon's whole journal.
  if (led && change == Change::kFollow) SendGoodbye();
  step.change = Note(change);
  if (roles_.role() != v1::ROLE_FOLLOWING || step.change != Change::kNone) return true;
  if (in_.daemon() != roles_.leader()) return true;
  if (!goes_on && sync_ != Sync::kAsked) {
    gap_ = true;
    Refetch();
  }
  const bool begins = in_.has_beginning();
  if (begins || sync_ == Sync::kFetching || sync_ == Sync::kReady) step.entry = &in_;
  if (begins) ahead_ns_ = best_ahead_ns_;
  step.own_ns = in_.now_ns() - ahead_ns_;
  return true;
}

Standby::Change Standby::OnTime() {
  const std::int64_t now_ns = Now_ns();
  const bool was_ready = ready();
  const Change change = Note(roles_.OnTime(now_ns, was_ready, whole()));
  if (change != Change::kNone || now_ns - sent_ns_ >= beat_ns_) {
    (void)NewEntry();
    Send(now_ns, clock_.base().Wall_ns());
  }
  if (now_ns - std::max(heard_ns_, reconnected_ns_) >= kReconnect_ns) {
    channel_->Reconnect();
    reconnected_ns_ = now_ns;
  }
  const bool late = asking_ && now_ns - asked_ns_ >= kAnswer_ns;
  const bool stuck = (sync_ == Sync::kFetching || (sync_ == Sync::kReady && !why_not_.empty())) &&
                     now_ns - asked_ns_ >= kAgain_ns;
  if (roles_.role() == v1::ROLE_FOLLOWING && (late || stuck)) Refetch();
  return change;
}

Status Standby::RequestLead() {
  if (leads()) return Status::Ok();
  if (!ready()) {
    return pipeline::Refused(v1::CODE_NOT_READY,
                             "lead: this daemon is not ready to take over: " + WhyNot());
  }
  roles_.RequestLead();
  (void)NewEntry();
  Send(Now_ns(), clock_.base().Wall_ns());
  return Status::Ok();
}

void Standby::Leave() {
  if (leads()) SendGoodbye();
}

void Standby::SendGoodbye() {
  NewEntry().set_role(v1::ROLE_LEAVING);
  Send(Now_ns(), clock_.base().Wall_ns());
}

bool Standby::wanted() const { return leads() && listens_ && Now_ns() - listened_ns_ < kHeard_ns; }

v1::Journal& Standby::NewEntry() {
  out_.Clear();
  out_.set_role(roles_.advertised_role());
  return out_;
}

void Standby::Send(std::int64_t now_ns, std::int64_t wall_ns) {
  const std::int64_t sent_ns = Now_ns();
  out_.set_version(kVersion);
  out_.set_daemon(daemon_);
  out_.set_epoch(epoch_);
  out_.set_term(roles_.advertised_term());
  out_.set_first(config_.first);
  out_.set_number(++number_);
  out_.set_now_ns(now_ns);
  out_.set_wall_ns(wall_ns);
  out_.set_hears(heard_ && sent_ns - heard_ns_ < kHeard_ns ? heard_daemon_ : 0);
  out_.set_hold_ns(static_cast<std::uint64_t>(roles_.hold_ns()));
  if (out_.has_beginning()) too_large_.clear();
  if (out_.has_beginning() || sent_ns - setup_sent_ns_ >= kSetupEvery_ns) {
    *out_.mutable_setup() = setup_;
    setup_sent_ns_ = sent_ns;
  }
  out_.SerializeToString(&bytes_);  // also computes the size
  if (bytes_.size() > channel_->max_bytes()) {
    NameTooLarge(bytes_.size());
    out_.SerializeToString(&bytes_);
  }
  channel_->Send(std::as_bytes(std::span(bytes_)));
  sent_ns_ = sent_ns;
}

void Standby::NameTooLarge(std::size_t bytes) {
  too_large_ = TitleOf(out_) + ": " + std::to_string(bytes) +
               " bytes for the standby, expected at most " + std::to_string(channel_->max_bytes());
  out_.set_too_large(too_large_);
  out_.clear_setup();
  complaint_ = config_.peer + " cannot stand in: " + too_large_;
}

int Standby::DoSubscriptions() {
  const std::int64_t now_ns = Now_ns();
  int read = 0;
  for (; read < kSubscriptionsPerTurn; ++read) {
    const Channel::Subscription next = channel_->NextSubscription();
    if (next == Channel::Subscription::kNone) break;
    if (next == Channel::Subscription::kEnded) continue;
    // It is connected, although its own messages may not have arrived yet. A peer that was not
    // connected before has not received the setup, so the next message includes it.
    if (!listens_ || now_ns - listened_ns_ >= kHeard_ns) setup_sent_ns_ = now_ns - kSetupEvery_ns;
    listened_ns_ = now_ns;
    listens_ = true;
    ++asked_count_;
    if (std::exchange(asked_, true)) ++asked_too_often_;
    ++asks_;
  }
  if (now_ns - asks_window_ns_ >= kStateEvery_ns) {
    if (asks_ > kUsualAsks) {
      complaint_ = "the journal was subscribed to " + std::to_string(asks_) +
                   " times in a second, expected once by " + config_.peer +
                   ": who else connects to standby.address?";
    }
    asks_ = 0;
    asks_window_ns_ = now_ns;
  }
  return read;
}

bool Standby::PopAsked() {
  const std::int64_t now_ns = Now_ns();
  if (!leads() || !asked_ || now_ns < next_state_ns_) return false;
  const std::int64_t saved_ns = kStateEvery_ns * (kStatesAtOnce - 1);
  next_state_ns_ = std::max(next_state_ns_, now_ns - saved_ns) + kStateEvery_ns;
  asked_ = false;
  return true;
}

bool Standby::whole() const { return sync_ == Sync::kReady && !gap_ && why_not_.empty(); }

bool Standby::ready() const {
  return whole() && stranger_ns_ == 0 && peer_setup_known_ && differs_.empty() &&
         apart_of_last_.count() <= kMostApart;
}

void Standby::Refetch() {
  const std::int64_t now_ns = Now_ns();
  if (asking_ && now_ns - asked_ns_ < kAnswer_ns) return;
  asked_ns_ = now_ns;
  asking_ = true;
  if (sync_ != Sync::kReady) sync_ = Sync::kAsked;
  channel_->Ask();
}

bool Standby::Begin(const v1::Journal& entry) {
  if (sync_ == Sync::kReady && !asking_ && !entry.beginning().changed()) return false;
  ++fetched_;
  epoch_ = entry.epoch();
  asked_ns_ = Now_ns();
  asking_ = gap_ = false;
  why_not_.clear();
  awaited_ = {kSettings};
  for (const std::string& style : entry.beginning().styles()) awaited_.insert(OfStyle(style));
  for (const std::uint32_t place : entry.beginning().fading()) awaited_.insert(OfFading(place));
  sync_ = Sync::kFetching;
  last.clear();
  return true;
}

void Standby::SettingsRestored(const v1::SettingsPart& part) {
  has_part_ = true;
  awaited_.insert(part.performers().begin(), part.performers().end());
  Restored(kSettings);
}

void Standby::StyleRestored(const v1::StylePart& part) {
  Restored(part.has_fading() ? OfFading(part.fading()) : OfStyle(part.name()));
}

void Standby::Restored(const std::string& performer) {
  awaited_.erase(performer);
  if (awaited_.empty() && sync_ == Sync::kFetching) sync_ = Sync::kReady;
}

void Standby::Failed(std::string why) {
  const bool was_ready = sync_ == Sync::kReady;
  if (why != why_not_) {
    why_not_ = std::move(why);
    complaint_ = "cannot stand in: " + why_not_;
  }
  if (!was_ready) return;
  sync_ = Sync::kFetching;
  awaited_.insert(kNobody);  // removed by the next fetch: at once, or kAgain_ns after the last one
  if (Now_ns() - asked_ns_ >= kAgain_ns) Refetch();
}

void Standby::Compared(log::Comparison comparison) {
  if (sync_ != Sync::kReady || gap_) return;
  const bool apart = comparison == log::Comparison::kApart;
  ++compared_;
  different_ += comparison == log::Comparison::kSame ? 0 : 1;
  apart_ += apart ? 1 : 0;
  apart_of_last_[compared_at_] = apart;
  compared_at_ = (compared_at_ + 1) % kWindow;
  if (apart && Now_ns() - asked_ns_ >= kAgain_ns) Refetch();
}

std::string Standby::WhyNot() const {
  if (roles_.role() == v1::ROLE_LOOKING) return "it checks whether the other daemon leads";
  if (!why_not_.empty()) return why_not_;
  if (stranger_ns_ != 0) return kOtherPair;
  if (!differs_.empty()) return DiffersText();
  if (apart_of_last_.count() > kMostApart) {
    return std::to_string(apart_of_last_.count()) + " of the last " + std::to_string(kWindow) +
           " poses differ from the leader's";
  }
  return "the state is being fetched";
}

void Standby::Describe(v1::StandbyState& state) const {
  state.set_role(Name(roles_.role()));
  state.set_peer(config_.peer);
  state.set_heard(heard_ && Now_ns() - heard_ns_ < kHeard_ns);
  state.set_peer_role(Name(roles_.peer().role));
  state.set_term(roles_.term());
  state.set_ready(ready());
  if (!leads() && !ready()) state.set_why_not(WhyNot());
  state.set_compared(compared_);
  state.set_different(different_);
  state.set_fetched(fetched_);
  state.set_takeovers(takeovers_);
  state.set_apart(apart_);
  for (const std::string& differs : differs_) state.add_differs(differs);
  state.set_refused(refused_);
  state.set_refused_why(refused_why_);
  state.set_asked(asked_count_);
  state.set_asked_too_often(asked_too_often_);
  state.set_too_large(too_large_);
}

}  // namespace styled::standby
