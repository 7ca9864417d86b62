#include "daemon/pipeline/pipeline.h"

#include "daemon/pipeline/calibration.h"
#include "daemon/pipeline/checkpoints.h"
#include "daemon/pipeline/setup.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using runtime::Nanoseconds;

constexpr int kSubscriptionsPerCycle = 16;
// One: frames that wait are handled between two requests, however many an operator sends.
constexpr int kCommandsPerCycle = 1;

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
      stats_(to_, roster_, layers_, transports_, stages_, subscriptions_),
      log_(to_.clock, to_.counters, to_.mailboxes) {
  rules_ = {Nanoseconds(roster_.config().performers.takeover_s),
            Nanoseconds(roster_.config().performers.clock_back_s)};
  roster_.Age(to_.clock.Now_ns());
  TellSetup();
}

void Pipeline::SetLayers(const std::vector<config::Source>& sources) {
  layers_.Set(sources);
  source_settings_ = SettingsOf(sources);
  TellSetup();
}

int Pipeline::DoWork() {
  const std::int64_t begin_ns = to_.clock.Now_ns();
  int work = to_.standby != nullptr ? DoStandby() : 0;
  work += DoPutOff();
  for (const auto& transport : transports_) {
    work += leads() ? transport->DoWork(*this) : transport->DoWork(holder_);
  }
  // While frames may still wait in a socket, no performer counts as silent; but check at least
  // every kBusyCycles cycles.
  constexpr int kBusyCycles = 64;
  const bool drained = work == 0 || ++busy_cycles_ >= kBusyCycles;
  if (drained) busy_cycles_ = 0;
  work += DoCommands();
  work += DoReloads();
  work += DoTakes(begin_ns);
  work += DoTimers(begin_ns, drained);
  work += DoSubscriptions();
  const std::int64_t end_ns = to_.clock.Now_ns();
  if (work > 0) stats_.NoteCycle(end_ns - begin_ns);
  if (work > 0 && to_.relieves && leads()) BalanceLoad(end_ns);
  return work;
}

int Pipeline::DoCommands() {
  std::unique_ptr<Exchange> exchange;
  int work = 0;
  while (work < kCommandsPerCycle && to_.mailboxes.commands.Pop(exchange)) {
    ++work;
    if (RefusesOrders(*exchange) || DoesLead(*exchange)) {
      Return(std::move(exchange));
      continue;
    }
    if (exchange->request.has_like()) {
      if (!takes_.Begin(exchange, roster_, to_.clock.Now_ns())) Return(std::move(exchange));
      continue;
    }
    Answer(exchange->request, exchange->reply);
    Return(std::move(exchange));
  }
  if (commands_.PopChanged()) {
    auto kept = roster_.Snapshot();
    if (!to_.mailboxes.profiles.Push(std::move(kept))) commands_.MarkChanged();
  }
  return work;
}

// Passes on what performers have shown of a style.
int Pipeline::DoTakes(std::int64_t now_ns) {
  int work = 0;
  while (!takes_.empty()) {
    std::unique_ptr<Exchange> exchange = takes_.Pop(now_ns);
    if (exchange == nullptr) break;
    ++work;
    if (exchange->reply.code() != v1::CODE_OK) {
      Return(std::move(exchange));
    } else if (to_.mailboxes.takes.Push(std::move(exchange))) {
      to_.mailboxes.wake_files.Signal();
    } else {
      exchange->reply.set_code(v1::CODE_BUSY);
      exchange->reply.set_reason("like: too many examples are waiting; try again");
      Return(std::move(exchange));
    }
  }
  return work;
}

// Sends a request with its reply back.
void Pipeline::Return(std::unique_ptr<Exchange> exchange) {
  JournalRequest(exchange->request, exchange->reply);
  if (to_.recorder != nullptr) {
    to_.recorder->OnRequest(to_.clock.Now_ns(), exchange->request, exchange->reply);
  }
  to_.counters.Add(Counter::kPipelineCommands);
  // Never full: the control thread keeps fewer requests in flight than the ring holds.
  if (to_.mailboxes.replies.Push(std::move(exchange))) to_.mailboxes.wake_control.Signal();
}

std::unique_ptr<std::vector<Profile>> Pipeline::PopUnsaved() {
  const bool learned = std::ranges::any_of(roster_.performers, [](const auto& performer) {
    return performer->profile.configured && performer->TellNeutral().has_value();
  });
  if (roster_.PopChanged() || learned) commands_.MarkChanged();
  return commands_.PopChanged() ? roster_.Snapshot() : nullptr;
}

void Pipeline::Answer(const v1::Request& request, v1::Reply& reply) {
  if (request.has_calibrate()) {
    Performer* const performer =
        Calibrate(request, transports_, roster_, to_.clock.Now_ns(), reply);
    if (performer == nullptr) return;
    performer->outputs.SendBodies(to_.publisher);
    commands_.MarkChanged();
    return;
  }
  if (request.has_take_checkpoint()) {
    return TakeCheckpoint(request, roster_, to_.clock.Now_ns(), to_.clock.Wall_ns(), reply);
  }
  if (request.has_restore_checkpoint()) {
    Performer* const performer =
        RestoreCheckpoint(request, roster_, layers_, to_.clock.Now_ns(), reply);
    if (performer == nullptr) return;
    performer->outputs.SendBodies(to_.publisher);
    log_.Log(Event::Level::kInfo, performer->profile.id + ": restored from a checkpoint");
    commands_.MarkChanged();
    return;
  }
  if (commands_.Apply(request, reply)) return;
  stats_.Fill(*reply.mutable_status());
}

int Pipeline::DoReloads() {
  Reload reload;
  if (!to_.mailboxes.reloads.Pop(reload)) return 0;
  DisownStyle(reload);
  const bool done = reload.exchange != nullptr && reload.exchange->reply.code() == v1::CODE_OK;
  // Looks name styles as the new configuration does before it resolves them.
  if (done) commands_.FollowStyles(reload.exchange->request, reload.exchange->reply);
  if (reload.config != nullptr) TakeOver(std::move(reload.config), reload.exchange == nullptr);
  if (done) commands_.Show(reload.exchange->request, reload.exchange->reply);
  if (reload.exchange == nullptr) {
    tells_all_ = true;  // the standby may have to complain
    if (!leads()) to_.standby->Refetch();
    return 1;
  }
  if (reload.exchange->followed) {
    StylesFollowed(*reload.exchange);
    return 1;
  }
  Return(std::move(reload.exchange));
  return 1;
}

void Pipeline::TakeOver(std::shared_ptr<const RuntimeConfig> config, bool reloaded) {
  for (auto& complaint : roster_.Apply(std::move(config))) {
    log_.Log(Event::Level::kWarning, std::move(complaint));
  }
  rules_ = {Nanoseconds(roster_.config().performers.takeover_s),
            Nanoseconds(roster_.config().performers.clock_back_s)};
  TellSetup();
  if (to_.recorder != nullptr && reloaded) {
    to_.recorder->OnNote(to_.clock.Now_ns(), "reloaded: weights " + roster_.config().weights_name);
  }
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
    if (performer->outputs.Asked()) performer->outputs.SendBodies(to_.publisher);
  }
  return work;
}

void Pipeline::OnNote(int source, const std::string& text) {
  log_.Log(Event::Level::kWarning,
           roster_.source_names()[static_cast<std::size_t>(source)] + ": " + text);
}

void Pipeline::OnNotice(int source, const std::string& text) {
  log_.Log(Event::Level::kInfo,
           roster_.source_names()[static_cast<std::size_t>(source)] + ": " + text);
}

}  // namespace styled::pipeline
