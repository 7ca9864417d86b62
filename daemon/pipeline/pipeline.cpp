#include "daemon/pipeline/pipeline.h"

#include <algorithm>

#include "model/base/text.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using runtime::kSecond_ns;
using runtime::Nanoseconds;

constexpr int kSubscriptionsPerCycle = 16;
constexpr int kCommandsPerCycle = 8;
constexpr std::int64_t kBudget_ns = kSecond_ns / 120;
constexpr std::int64_t kStaysWarm_ns = 2 * runtime::kMillisecond_ns;

// What `look` was before it was one message.
void FillFormerFields(v1::PerformerStats& row) {
  const v1::Look& look = row.look();
  *row.mutable_styles() = look.mix();
  row.set_strength(look.strength());
  row.set_preset(look.preset());
  if (PartsOf(look) != body::kAllParts) *row.mutable_only() = look.parts();
  row.set_own_style(look.input_style());
}

}  // namespace

Pipeline::Pipeline(const Dependencies& dependencies, std::vector<std::string> source_names,
                   std::vector<std::unique_ptr<source::Transport>> transports,
                   std::shared_ptr<const RuntimeConfig> config, std::uint64_t epoch,
                   int max_subscriptions)
    : to_(dependencies),
      transports_(std::move(transports)),
      subscriptions_(max_subscriptions, to_.counters),
      roster_(std::move(source_names), std::move(config), epoch, subscriptions_, to_.counters),
      commands_(roster_),
      started_ns_(to_.clock.Now_ns()),
      next_stats_ns_(started_ns_ + kSecond_ns) {
  rules_ = {Nanoseconds(roster_.config().performers.takeover_s),
            Nanoseconds(roster_.config().performers.clock_back_s)};
  subscriptions_.Register(stats_topic_);
  roster_.Age(started_ns_);
}

int Pipeline::DoWork() {
  const std::int64_t begin_ns = to_.clock.Now_ns();
  int work = 0;
  for (const auto& transport : transports_) work += transport->DoWork(*this);
  // Nobody is silent whose frames may still wait in a socket.
  constexpr int kBusyCycles = 64;
  const bool drained = work == 0 || ++busy_cycles_ >= kBusyCycles;
  if (drained) busy_cycles_ = 0;
  work += DoCommands();
  work += DoReloads();
  work += DoTimers(begin_ns, drained);
  work += DoSubscriptions();
  if (work > 0) {
    const std::int64_t cycle_ns = to_.clock.Now_ns() - begin_ns;
    longest_cycle_ns_ = std::max(longest_cycle_ns_, cycle_ns);
    if (cycle_ns > kBudget_ns) to_.counters.Add(Counter::kPipelineOverBudget);
  }
  return work;
}

std::int64_t Pipeline::NextDeadline_ns() const {
  std::int64_t next_ns = next_stats_ns_;
  for (const auto& transport : transports_) {
    next_ns = std::min(next_ns, transport->NextDeadline_ns());
  }
  for (const auto& performer : roster_.performers) {
    const auto& limits = roster_.config().performers;
    const std::int64_t silent_ns =
        performer->live
            ? performer->last_frame_ns + performer->Patience_ns(Nanoseconds(limits.stale_s))
            : performer->session.last_arrival_ns() + Nanoseconds(limits.forget_s);
    next_ns = std::min({next_ns, performer->next_body_ns, silent_ns});
    if (to_.anticipate) next_ns = std::min(next_ns, performer->anticipation.prepare_ns());
  }
  return next_ns;
}

bool Pipeline::Expects(std::int64_t now_ns) const {
  return to_.anticipate &&
         std::any_of(roster_.performers.begin(), roster_.performers.end(),
                     [now_ns](const auto& p) { return p->anticipation.Expects(now_ns); });
}

// While frames keep coming the caches are warm by themselves.
void Pipeline::Prepare(Performer& performer, std::int64_t now_ns) {
  if (!performer.anticipation.Prepare(now_ns)) return;
  if (!to_.prewarm || now_ns - receive_ns_ < kStaysWarm_ns) return;
  performer.Prewarm();
  to_.counters.Add(Counter::kPipelinePrewarmed);
}

int Pipeline::DoCommands() {
  std::unique_ptr<Exchange> exchange;
  int work = 0;
  while (work < kCommandsPerCycle && to_.mailboxes.commands.Pop(exchange)) {
    ++work;
    Answer(*exchange);
    if (to_.recorder != nullptr) {
      to_.recorder->OnRequest(to_.clock.Now_ns(), exchange->request, exchange->reply);
    }
    to_.counters.Add(Counter::kPipelineCommands);
    // Never full: the control thread keeps fewer in flight than the ring holds.
    if (to_.mailboxes.replies.Push(std::move(exchange))) to_.mailboxes.wake_control.Signal();
  }
  if (commands_.PopChanged()) {
    auto kept = roster_.Snapshot();
    if (!to_.mailboxes.profiles.Push(std::move(kept))) commands_.MarkChanged();
  }
  return work;
}

std::unique_ptr<std::vector<Profile>> Pipeline::PopUnsaved() {
  if (roster_.PopChanged()) commands_.MarkChanged();
  return commands_.PopChanged() ? roster_.Snapshot() : nullptr;
}

void Pipeline::Answer(Exchange& exchange) {
  if (exchange.request.has_calibrate()) return Calibrate(exchange.request, exchange.reply);
  if (commands_.Apply(exchange.request, exchange.reply)) return;
  auto& status = *exchange.reply.mutable_status();
  status.set_version(STYLED_VERSION);
  status.set_epoch(roster_.epoch());
  status.set_uptime_s(static_cast<double>(to_.clock.Now_ns() - started_ns_) * 1e-9);
  status.set_weights(roster_.config().weights_name);
  FillStats(*status.mutable_stats());
  for (std::size_t i = 0; i < transports_.size(); ++i) {
    DescribeSource(i, *status.add_sources());
  }
}

void Pipeline::DescribeSource(std::size_t index, v1::SourceInfo& info) const {
  const source::Transport& transport = *transports_[index];
  info.set_name(roster_.source_names()[index]);
  if (index < source_types_.size()) info.set_type(source_types_[index]);
  info.set_listen(transport.endpoint());
  info.set_received(transport.received());
  const source::Smoothing smoothing = transport.smoothing();
  info.set_delay_ms(smoothing.delay_ms);
  info.set_arrived_ms(smoothing.arrived_ms);
  info.set_left_ms(smoothing.left_ms);
  info.set_missed(smoothing.missed);
}

void Pipeline::Calibrate(const v1::Request& request, v1::Reply& reply) {
  reply.set_id(request.id());
  Profile* profile = roster_.FindProfile(request.performer());
  Performer* performer = profile == nullptr ? nullptr : roster_.LiveOf(*profile);
  if (performer == nullptr) {
    reply.set_code(v1::CODE_UNKNOWN_PERFORMER);
    reply.set_reason("performer \"" + Printable(request.performer(), 80) +
                     "\": expected one that is here");
    return;
  }
  const v1::Calibrate& wanted = request.calibrate();
  if (!v1::Calibrate::Pose_IsValid(wanted.pose()) ||
      !v1::Calibrate::Sensors_IsValid(wanted.sensors())) {
    reply.set_code(v1::CODE_OUT_OF_RANGE);
    reply.set_reason("calibrate: expected a pose of 0 or 1, sensors of 0 to 2");
    return;
  }
  source::Transport& transport = *transports_[static_cast<std::size_t>(performer->source)];
  if (transport.has_sensors()) {
    const Status status =
        transport.Calibrate(static_cast<source::Calibration>(wanted.sensors()), to_.clock.Now_ns());
    reply.set_code(status.ok() ? v1::CODE_OK : v1::CODE_NOT_READY);
    reply.set_reason(status.message());
  } else {
    reply.set_code(performer->Calibrate(wanted, roster_.config(), to_.clock.Now_ns(), reply));
  }
  if (reply.code() != v1::CODE_OK) return;
  profile->configured = true;
  auto& applied = *reply.add_applied();
  applied.set_performer(profile->id);
  applied.set_first_sequence(profile->next_sequence);
  performer->SendBodies(to_.publisher);
  commands_.MarkChanged();
}

int Pipeline::DoReloads() {
  std::shared_ptr<const RuntimeConfig> config;
  if (!to_.mailboxes.reloads.Pop(config)) return 0;
  for (auto& complaint : roster_.Apply(std::move(config))) {
    Log(Event::Level::kWarning, std::move(complaint));
  }
  rules_ = {Nanoseconds(roster_.config().performers.takeover_s),
            Nanoseconds(roster_.config().performers.clock_back_s)};
  if (to_.recorder != nullptr) {
    to_.recorder->OnNote(to_.clock.Now_ns(), "reloaded: weights " + roster_.config().weights_name);
  }
  return 1;
}

int Pipeline::DoSubscriptions() {
  int work = 0;
  while (work < kSubscriptionsPerCycle && to_.publisher.NextSubscription(subscription_)) {
    ++work;
    if (subscription_.subscribe) {
      subscriptions_.Subscribe(subscription_.topic);
    } else {
      subscriptions_.Unsubscribe(subscription_.topic);
    }
  }
  if (work == 0) return 0;
  for (const auto& performer : roster_.performers) {
    if (performer->Asked()) performer->SendBodies(to_.publisher);
  }
  return work;
}

int Pipeline::DoTimers(std::int64_t now_ns, bool drained) {
  const auto& limits = roster_.config().performers;
  int work = 0;
  for (std::size_t i = 0; i < roster_.performers.size();) {
    Performer& performer = *roster_.performers[i++];
    const std::int64_t silence_ns = now_ns - performer.session.last_arrival_ns();
    if (to_.anticipate && drained) Prepare(performer, now_ns);
    if (drained && performer.live &&
        now_ns - performer.last_frame_ns >= performer.Patience_ns(Nanoseconds(limits.stale_s))) {
      Stale(performer, now_ns);
      ++work;
    }
    if (performer.FacingChanged()) {
      const std::string warning = performer.Warning();
      LogOf(LogLimit::Kind::kFacing, {}, performer.profile.id,
            warning.empty() ? Event::Level::kInfo : Event::Level::kWarning,
            warning.empty() ? "walks where the toes point again" : warning);
    }
    if (drained && !performer.live && silence_ns >= Nanoseconds(limits.forget_s)) {
      LogOf(LogLimit::Kind::kForgotten, {}, performer.profile.id, Event::Level::kInfo,
            "forgotten after silence");
      to_.counters.Add(Counter::kPipelineForgotten);
      roster_.Forget(performer);
      --i;
      ++work;
    } else if (now_ns >= performer.next_body_ns) {
      performer.next_body_ns = now_ns + kSecond_ns;
      performer.SendBodies(to_.publisher);
      ++work;
    }
  }
  if (now_ns >= next_stats_ns_) {
    PublishStats();
    roster_.Age(now_ns);
    for (auto& text : roster_.PopLog()) Log(Event::Level::kInfo, std::move(text));
    if (roster_.PopChanged()) commands_.MarkChanged();
    ++work;
  }
  return work;
}

void Pipeline::Stale(Performer& performer, std::int64_t now_ns) {
  performer.live = false;
  Performer::FrameContext context;
  context.receive_ns = performer.last_frame_ns;
  context.publish_ns = now_ns;
  context.wall_ns = to_.clock.Wall_ns();
  if (!performer.Repeat(context)) return;
  performer.Send(to_.publisher, now_ns);
  to_.counters.Add(Counter::kPipelineStale);
}

void Pipeline::FillStats(v1::Stats& stats) {
  stats.set_epoch(roster_.epoch());
  stats.set_wall_time_ns(static_cast<std::uint64_t>(to_.clock.Wall_ns()));
  for (int i = 0; i < static_cast<int>(Counter::kCount); ++i) {
    auto& counter = *stats.add_counters();
    counter.set_name(std::string(runtime::Name(static_cast<Counter>(i))));
    counter.set_value(to_.counters.Get(static_cast<Counter>(i)));
  }
  for (const auto& [id, profile] : roster_.profiles) {
    auto& row = *stats.add_performers();
    row.set_performer(id);
    row.set_sequence(profile->next_sequence - 1);
    row.set_pinned(profile->pinned);
    *row.mutable_look() = profile->look;
    FillFormerFields(row);
    if (const Performer* live = roster_.LiveOf(*profile)) live->Describe(row);
  }
  for (std::size_t i = 0; i < transports_.size(); ++i) DescribeSource(i, *stats.add_sources());
  stages_.Describe(stats);
}

void Pipeline::PublishStats() {
  const std::int64_t now_ns = to_.clock.Now_ns();
  next_stats_ns_ = std::max(next_stats_ns_ + kSecond_ns, now_ns + kSecond_ns / 2);
  for (const auto& performer : roster_.performers) performer->Sample();
  stages_.Sample();
  to_.counters.Set(Counter::kPipelineLongestCycleUs,
                   static_cast<std::uint64_t>(longest_cycle_ns_ / 1000));
  longest_cycle_ns_ = 0;
  if (stats_topic_.wanted == 0) return;
  v1::Stats stats;
  FillStats(stats);
  stats.SerializeToString(&stats_bytes_);
  to_.publisher.Send(stats_topic_.name, std::as_bytes(std::span(stats_bytes_)));
}

void Pipeline::OnNote(int source, const std::string& text) {
  Log(Event::Level::kWarning,
      roster_.source_names()[static_cast<std::size_t>(source)] + ": " + text);
}

void Pipeline::LogOf(LogLimit::Kind kind, const source::Machine& sender,
                     const std::string& performer, Event::Level level, std::string text) {
  std::uint64_t held_back = 0;
  if (!log_limit_.Admit(kind, sender, performer, to_.clock.Now_ns(), held_back)) {
    to_.counters.Add(Counter::kPipelineEventsHeldBack);
    return;
  }
  if (held_back > 0) text += " (and " + std::to_string(held_back) + " more like this before)";
  Log(level, performer + ": " + std::move(text));
}

void Pipeline::Log(Event::Level level, std::string text) {
  // It may quote what a stranger sent: no second line, no terminal's escape.
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7F') c = '?';
  }
  if (!to_.mailboxes.events.Push({level, std::move(text)})) {
    to_.counters.Add(Counter::kPipelineEventsDropped);
  }
}

}  // namespace styled::pipeline
