#include "daemon/pipeline/stats.h"

#include <algorithm>
#include <span>

#include "daemon/perform/terms.h"

namespace styled::pipeline {
namespace {

using runtime::Counter;
using runtime::kSecond_ns;

constexpr std::int64_t kBudget_ns = kSecond_ns / 120;

// Fills the fields that `look` has replaced, for older readers.
void FillFormerFields(v1::PerformerStats& row) {
  const v1::Look& look = row.look();
  *row.mutable_styles() = look.mix();
  row.set_strength(look.strength());
  row.set_preset(look.preset());
  if (PartsOf(look) != body::kAllParts) *row.mutable_only() = look.parts();
  row.set_own_style(look.input_style());
}

}  // namespace

Stats::Stats(const Dependencies& dependencies, const Roster& roster, const Layers& layers,
             const Transports& transports, Stages& stages, publish::Subscriptions& subscriptions)
    : dependencies_(dependencies),
      roster_(roster),
      layers_(layers),
      transports_(transports),
      stages_(stages),
      started_ns_(dependencies_.clock.Now_ns()),
      due_ns_(started_ns_ + kSecond_ns) {
  subscriptions.Register(topic_);
}

void Stats::NoteCycle(std::int64_t cycle_ns) noexcept {
  longest_cycle_ns_ = std::max(longest_cycle_ns_, cycle_ns);
  if (cycle_ns > kBudget_ns) dependencies_.counters.Add(Counter::kPipelineOverBudget);
}

void Stats::DescribeSource(std::size_t index, v1::SourceInfo& info) const {
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
  info.set_merge_into(layers_.Into(index));
  const std::int64_t now_ns = dependencies_.clock.Now_ns();
  if (layers_.Arrives(index, now_ns)) info.set_stray(layers_.Stray(index, roster_.Here(), now_ns));
  info.set_kernel_dropped(transport.kernel_dropped());
}

void Stats::DescribeClock(v1::ClockState& clock) const {
  const runtime::ClockDiscipline& discipline = dependencies_.clock_watch->discipline();
  clock.set_locked(discipline.locked);
  clock.set_max_error_s(discipline.max_error_s);
  if (!discipline.ptp) {
    clock.set_source(discipline.locked ? v1::ClockState::SOURCE_NTP : v1::ClockState::SOURCE_NONE);
    return;
  }
  const runtime::PtpClock& heard = *discipline.ptp;
  clock.set_source(v1::ClockState::SOURCE_PTP);
  v1::PtpState& ptp = *clock.mutable_ptp();
  ptp.set_port_state(ptp::Text(heard.port));
  ptp.set_domain(heard.domain);
  ptp.set_leader(ptp::Text(heard.parent.leader));
  ptp.set_leader_priority1(heard.parent.priority1);
  ptp.set_leader_priority2(heard.parent.priority2);
  ptp.set_leader_clock_class(heard.parent.clock_class);
  ptp.set_leader_accuracy(heard.parent.accuracy);
  ptp.set_leader_time_source(heard.properties.time_source);
  ptp.set_offset_s(heard.current.offset_s);
  ptp.set_mean_path_delay_s(heard.current.mean_path_delay_s);
  ptp.set_steps_removed(heard.current.steps_removed);
}

void Stats::Fill(v1::StatusReply& status) const {
  status.set_version(STYLED_VERSION);
  status.set_epoch(roster_.epoch());
  status.set_uptime_s(static_cast<double>(dependencies_.clock.Now_ns() - started_ns_) * 1e-9);
  status.set_weights(roster_.config().weights_name);
  for (const net::Terms& terms : roster_.config().terms) FillTerms(terms, *status.add_terms());
  Fill(*status.mutable_stats());
  for (std::size_t i = 0; i < transports_.size(); ++i) DescribeSource(i, *status.add_sources());
}

void Stats::Fill(v1::Stats& stats) const {
  stats.set_epoch(roster_.epoch());
  stats.set_wall_time_ns(static_cast<std::uint64_t>(dependencies_.clock.Wall_ns()));
  for (int i = 0; i < static_cast<int>(Counter::kCount); ++i) {
    auto& counter = *stats.add_counters();
    counter.set_name(std::string(runtime::Name(static_cast<Counter>(i))));
    counter.set_value(dependencies_.counters.Get(static_cast<Counter>(i)));
  }
  for (const auto& [id, profile] : roster_.profiles) {
    auto& row = *stats.add_performers();
    row.set_performer(id);
    row.set_sequence(profile->next_sequence - 1);
    row.set_pinned(profile->pinned);
    *row.mutable_look() = profile->look;
    FillFormerFields(row);
    for (std::string& network :
         NetworksOf(profile->look, roster_.config().network->model().styles)) {
      row.add_networks(std::move(network));
    }
    if (const Performer* live = roster_.LiveOf(*profile)) live->Describe(row);
    layers_.Describe(dependencies_.clock.Now_ns(), row);
  }
  for (std::size_t i = 0; i < transports_.size(); ++i) DescribeSource(i, *stats.add_sources());
  stages_.Describe(stats);
  if (dependencies_.clock_watch != nullptr && dependencies_.clock_watch->discipline().known) {
    DescribeClock(*stats.mutable_clock());
  }
  if (dependencies_.standby != nullptr) DescribeStandby(*stats.mutable_standby());
}

void Stats::DescribeStandby(v1::StandbyState& state) const {
  standby::Standby& standby = *dependencies_.standby;
  standby.Describe(state);
  if (standby.leads()) return;
  const std::int64_t since_ns = dependencies_.clock.Now_ns() - kSecond_ns;
  for (const auto& performer : roster_.performers) {
    if (!performer->admission.live()) continue;
    const std::string& id = performer->profile.id;
    if (standby.input().LastOf(roster_.source_names(), id) < since_ns) state.add_without_input(id);
  }
}

void Stats::Publish() {
  const std::int64_t now_ns = dependencies_.clock.Now_ns();
  due_ns_ = std::max(due_ns_ + kSecond_ns, now_ns + kSecond_ns / 2);
  for (const auto& performer : roster_.performers) performer->Sample(now_ns);
  for (const auto& transport : transports_) transport->Sample();
  stages_.Sample();
  if (dependencies_.clock_watch != nullptr) dependencies_.clock_watch->Update(now_ns);
  dependencies_.counters.Set(Counter::kPipelineLongestCycleUs,
                             static_cast<std::uint64_t>(longest_cycle_ns_ / 1000));
  longest_cycle_ns_ = 0;
  if (topic_.wanted == 0) return;
  v1::Stats stats;
  Fill(stats);
  stats.SerializeToString(&bytes_);
  dependencies_.publisher.Send(topic_.name, std::as_bytes(std::span(bytes_)));
}

}  // namespace styled::pipeline
