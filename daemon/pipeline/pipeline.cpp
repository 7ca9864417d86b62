#include "daemon/pipeline/pipeline.h"

#include <algorithm>

#include "daemon/looks/refusal.h"
#include "daemon/perform/load_balance.h"
#include "daemon/perform/requests.h"
#include "daemon/perform/silence.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;

constexpr int kSubscriptionsPerCycle = 16;
// One, so that waiting frames are processed between two requests, however many an operator sends.
constexpr int kCommandsPerCycle = 1;

}  // namespace

Pipeline::Pipeline(const Dependencies& dependencies, std::vector<std::string> source_names,
                   std::vector<std::unique_ptr<source::Transport>> transports,
                   std::shared_ptr<const RuntimeConfig> config, std::uint64_t epoch,
                   int max_subscriptions)
    : dependencies_(dependencies),
      transports_(std::move(transports)),
      performance_(dependencies_.clock, dependencies_.counters, dependencies_.publisher,
                   dependencies_.mailboxes, std::move(source_names), std::move(config), epoch,
                   max_subscriptions),
      frames_(performance_, dependencies_.standby != nullptr, dependencies_.helpers),
      stats_(dependencies_, performance_.roster, performance_.layers, transports_,
             performance_.stages, performance_.subscriptions),
      timers_(dependencies_, performance_, stats_) {
  performance_.log.Add(dependencies_.recorder);
  if (dependencies_.standby == nullptr) return;
  replication_.emplace(*dependencies_.standby, performance_, frames_, transports_,
                       dependencies_.mailboxes, *this);
  replication_->sender().AdvertiseSetup();
}

void Pipeline::SetLayers(const std::vector<config::Source>& sources) {
  performance_.layers.Set(sources);
  if (replication_) replication_->sender().AdvertiseSetup(sources);
}

int Pipeline::DoWork() {
  const std::int64_t begin_ns = performance_.clock.Now_ns();
  int work = replication_ ? replication_->DoWork() : 0;
  work += frames_.DoPostponed();
  work += DoSources();
  const bool drained = Drained(work > 0);
  work += DoCommands();
  work += DoReloads();
  work += DoTakes(begin_ns);
  work += timers_.DoWork(begin_ns, drained, frames_.receive_ns());
  work += DoSubscriptions();
  if (work == 0) return 0;
  const std::int64_t end_ns = performance_.clock.Now_ns();
  stats_.NoteCycle(end_ns - begin_ns);
  if (dependencies_.relieves && dependencies_.leads()) BalanceLoad(performance_, end_ns);
  return work;
}

std::int64_t Pipeline::NextDeadline_ns() const {
  std::int64_t next_ns = timers_.NextDeadline_ns(frames_.receive_ns());
  for (const auto& transport : transports_) {
    next_ns = std::min(next_ns, transport->NextDeadline_ns());
  }
  if (dependencies_.standby != nullptr)
    next_ns = std::min(next_ns, dependencies_.standby->NextDeadline_ns());
  return next_ns;
}

int Pipeline::DoSources() {
  source::Receiver& receiver = replication_ ? replication_->receiver() : *this;
  int work = 0;
  for (const auto& transport : transports_) work += transport->DoWork(receiver);
  return work;
}

// While frames may still wait in a socket, no performer counts as silent. Silence is checked at
// least every kBusyCycles cycles.
bool Pipeline::Drained(bool worked) {
  constexpr int kBusyCycles = 64;
  const bool drained = !worked || ++busy_cycles_ >= kBusyCycles;
  if (drained) busy_cycles_ = 0;
  return drained;
}

void Pipeline::OnFrames(int source, std::span<const source::SourceFrame> frames,
                        bool more_waiting) {
  Batch batch{.source = source, .frames = frames, .more_waiting = more_waiting};
  if (dependencies_.decisions != nullptr) {
    batch.leaders = dependencies_.decisions->Of(source, frames);
  }
  (void)frames_.Process(batch);
}

void Pipeline::OnSilence(const v1::Silence& silence) {
  PerformSilence(performance_, silence, performance_.clock.Now_ns());
}

int Pipeline::DoCommands() {
  std::unique_ptr<Exchange> exchange;
  int work = 0;
  for (; work < kCommandsPerCycle && dependencies_.mailboxes.commands.Pop(exchange); ++work) {
    Perform(std::move(exchange));
  }
  if (performance_.commands.PopChanged()) {
    auto kept = performance_.roster.Snapshot();
    if (!dependencies_.mailboxes.profiles.Push(std::move(kept)))
      performance_.commands.MarkChanged();
  }
  return work;
}

void Pipeline::Perform(std::unique_ptr<Exchange> exchange) {
  const v1::Request& request = exchange->request;
  if (replication_ && replication_->Answers(*exchange)) return Return(std::move(exchange));
  if (request.has_lead()) {  // without a standby this daemon always leads
    exchange->reply.set_id(request.id());
    return Return(std::move(exchange));
  }
  if (request.has_like()) {
    exchange->reply.set_id(request.id());
    const Status status =
        performance_.takes.Begin(exchange, performance_.roster, performance_.clock.Now_ns());
    if (status.ok()) return;
    FillReply(status, exchange->reply);
    return Return(std::move(exchange));
  }
  if (!PerformRequest(request, transports_, performance_, exchange->reply)) {
    stats_.Fill(*exchange->reply.mutable_status());
  }
  Return(std::move(exchange));
}

// Passes complete takes of performers to the files thread.
int Pipeline::DoTakes(std::int64_t now_ns) {
  int work = 0;
  while (!performance_.takes.empty()) {
    std::unique_ptr<Exchange> exchange = performance_.takes.Pop(now_ns);
    if (exchange == nullptr) break;
    ++work;
    if (exchange->reply.code() != v1::CODE_OK) {
      Return(std::move(exchange));
    } else if (dependencies_.mailboxes.takes.Push(std::move(exchange))) {
      dependencies_.mailboxes.wake_files.Signal();
    } else {
      FillReply(Refused(v1::CODE_BUSY, "like: too many examples are waiting; try again"),
                exchange->reply);
      Return(std::move(exchange));
    }
  }
  return work;
}

// Returns a request with its reply.
void Pipeline::Return(std::unique_ptr<Exchange> exchange) {
  performance_.log.OnRequest(performance_.clock.Now_ns(), exchange->request, exchange->reply);
  performance_.counters.Add(Counter::kPipelineCommands);
  // Never full: the control thread keeps fewer requests in flight than the ring holds.
  if (dependencies_.mailboxes.replies.Push(std::move(exchange)))
    dependencies_.mailboxes.wake_control.Signal();
}

std::unique_ptr<std::vector<Profile>> Pipeline::PopUnsaved() {
  const bool learned =
      std::ranges::any_of(performance_.roster.performers, [](const auto& performer) {
        return performer->profile.configured && performer->TellNeutral().has_value();
      });
  if (performance_.roster.PopChanged() || learned) performance_.commands.MarkChanged();
  return performance_.commands.PopChanged() ? performance_.roster.Snapshot() : nullptr;
}

int Pipeline::DoReloads() {
  Reload reload;
  if (!dependencies_.mailboxes.reloads.Pop(reload)) return 0;
  if (replication_) replication_->OnReload(reload);
  Exchange* const exchange = reload.exchange.get();  // null: the configuration was read again
  const bool done = exchange != nullptr && exchange->reply.code() == v1::CODE_OK;
  // Renames and removes styles in the looks before the new configuration resolves their names.
  if (done) performance_.commands.FollowStyles(exchange->request, exchange->reply);
  if (reload.config != nullptr) Adopt(std::move(reload.config), exchange == nullptr);
  if (done) performance_.commands.Show(exchange->request, exchange->reply);
  if (exchange == nullptr) {
    if (replication_) replication_->OnConfigRead();
  } else if (exchange->followed) {
    replication_->OnStyleFollowed(*exchange);
  } else {
    Return(std::move(reload.exchange));
  }
  return 1;
}

void Pipeline::Adopt(std::shared_ptr<const RuntimeConfig> config, bool reloaded) {
  performance_.Adopt(std::move(config));
  if (replication_) replication_->sender().AdvertiseSetup();
  if (reloaded)
    performance_.log.OnReload(performance_.clock.Now_ns(),
                              performance_.roster.config().weights_name);
}

int Pipeline::DoSubscriptions() {
  int work = 0;
  while (work < kSubscriptionsPerCycle && performance_.publisher.NextSubscription(subscription_)) {
    ++work;
    if (subscription_.subscribe) {
      performance_.subscriptions.Subscribe(subscription_.topic);
    } else {
      performance_.subscriptions.Unsubscribe(subscription_.topic);
    }
  }
  if (work == 0) return 0;
  for (const auto& performer : performance_.roster.performers) {
    if (performer->outputs.Asked()) performer->outputs.SendBodies(performance_.publisher);
  }
  return work;
}

void Pipeline::OnNote(int source, const std::string& text) {
  performance_.events.Log(
      Event::Level::kWarning,
      performance_.roster.source_names()[static_cast<std::size_t>(source)] + ": " + text);
}

void Pipeline::OnNotice(int source, const std::string& text) {
  performance_.events.Log(
      Event::Level::kInfo,
      performance_.roster.source_names()[static_cast<std::size_t>(source)] + ": " + text);
}

}  // namespace styled::pipeline
