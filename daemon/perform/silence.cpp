#include "daemon/perform/silence.h"

namespace styled::pipeline {

bool SendStale(Performance& performance, Performer& performer, std::int64_t now_ns) {
  performer.admission.MarkStale();
  decide::FrameInTransit now;
  now.arrival_ns = now.receive_ns = performer.admission.last_frame_ns();
  now.publish_ns = now_ns;
  now.wall_ns = performance.clock.Wall_ns();
  if (!performer.Repeat(now)) return false;
  performer.Send(performance.publisher, performance.bundles, now_ns);
  performance.SendBundles();
  performance.counters.Add(runtime::Counter::kPipelineStale);
  performer.history.Add(performer.frame());
  return true;
}

bool SendIdle(Performance& performance, Performer& performer, std::int64_t elapsed_ns,
              std::int64_t now_ns) {
  decide::FrameInTransit now;
  now.elapsed_ns = elapsed_ns;
  now.arrival_ns = now.receive_ns = now_ns;
  now.wall_ns = performance.clock.Wall_ns();
  const bool alone = performance.roster.performers.size() == 1;
  now.face = performance.layers.FaceOf(performer.profile.id, alone, {}, now_ns);
  if (!performer.AcceptSilent(now)) return false;
  const stylist::Stylist::Job job = performer.Style();
  stylist::Stylist::ProcessTogether({&job, 1});
  performer.Attach();
  performer.Finish(performance.clock.Now_ns());
  performer.Send(performance.publisher, performance.bundles, now_ns);
  performance.SendBundles();
  performance.counters.Add(runtime::Counter::kPipelineIdle);
  performer.history.Add(performer.frame());
  return true;
}

void PerformSilence(Performance& performance, const v1::Silence& silence, std::int64_t now_ns) {
  Roster& roster = performance.roster;
  const auto live = [&roster](const std::string& id) {
    Profile* const profile = roster.FindProfile(id);
    return profile == nullptr ? nullptr : roster.LiveOf(*profile);
  };
  for (const v1::Applied& stale : silence.stale()) {
    Performer* const performer = live(stale.performer());
    if (performer == nullptr) continue;
    performer->profile.next_sequence = stale.first_sequence();
    SendStale(performance, *performer, now_ns);
  }
  for (const v1::IdleFrame& idle : silence.idle()) {
    Performer* const performer = live(idle.performer());
    if (performer == nullptr) continue;
    performer->profile.next_sequence = idle.published();
    SendIdle(performance, *performer, idle.elapsed_ns(), now_ns);
  }
  for (const std::string& id : silence.forgotten()) {
    if (Performer* const performer = live(id); performer != nullptr) roster.Forget(*performer);
  }
}

}  // namespace styled::pipeline
