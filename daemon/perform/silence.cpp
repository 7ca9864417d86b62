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

}  // namespace styled::pipeline
