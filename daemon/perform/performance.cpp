#include "daemon/perform/performance.h"

#include <algorithm>

namespace styled::pipeline {

using runtime::Nanoseconds;

decide::Limits Performance::LimitsOf(const config::Performers& performers) {
  return {.rules = {Nanoseconds(performers.takeover_s), Nanoseconds(performers.clock_back_s)},
          .late_ns = Nanoseconds(performers.late_s),
          .backlog_ns = Nanoseconds(performers.backlog_s)};
}

void Performance::Adopt(std::shared_ptr<const RuntimeConfig> config) {
  for (auto& complaint : roster.Apply(std::move(config))) {
    events.Log(Event::Level::kWarning, std::move(complaint));
  }
  decider.SetLimits(LimitsOf(roster.config().performers));
}

// One message a cycle, for who shows the whole stage.
bool Performance::SendBundles() noexcept {
  if (std::ranges::all_of(bundles, &publish::Bundle::empty)) return false;
  const std::int64_t begin_ns = clock.Now_ns();
  for (publish::Bundle& bundle : bundles) bundle.Send(publisher);
  stages.Add(Stages::kSend, clock.Now_ns() - begin_ns);
  return true;
}

}  // namespace styled::pipeline
