#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "daemon/decide/decider.h"
#include "daemon/decide/overload.h"
#include "daemon/log/writer.h"
#include "daemon/looks/mailboxes.h"
#include "daemon/looks/runtime_config.h"
#include "daemon/perform/commands.h"
#include "daemon/perform/event_log.h"
#include "daemon/perform/merge/layers.h"
#include "daemon/perform/roster.h"
#include "daemon/perform/stages.h"
#include "daemon/perform/takes.h"
#include "daemon/publish/bundle.h"
#include "daemon/publish/publisher.h"
#include "daemon/publish/subscriptions.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/counters.h"

namespace styled::pipeline {

// What frames, requests and silence act on: the performers with their settings, what sources merge
// into them, and the topics on which they are published. Whoever performs an entry of the log
// (FrameProcessor, requests.h, silence.h) gets it as argument. Pipeline thread.
struct Performance {
  // The first four must outlive it.
  Performance(runtime::Clock& the_clock, runtime::Counters& the_counters,
              publish::Publisher& the_publisher, Mailboxes& mailboxes,
              std::vector<std::string> source_names, std::shared_ptr<const RuntimeConfig> config,
              std::uint64_t epoch, int max_subscriptions)
      : clock(the_clock),
        counters(the_counters),
        publisher(the_publisher),
        subscriptions(max_subscriptions, counters),
        roster(std::move(source_names), std::move(config), epoch, subscriptions, counters),
        commands(roster),
        decider(LimitsOf(roster.config().performers)),
        events(clock, counters, mailboxes) {
    roster.Age(clock.Now_ns());
  }
  Performance(const Performance&) = delete;
  Performance& operator=(const Performance&) = delete;

  static decide::Limits LimitsOf(const config::Performers& performers);
  // Takes over another configuration: weights, presets, limits. Logs what no longer fits.
  // Allocates.
  void Adopt(std::shared_ptr<const RuntimeConfig> config);
  // Sends the bundles of what was serialized since the last call. Returns whether there was one.
  bool SendBundles() noexcept;

  runtime::Clock& clock;
  runtime::Counters& counters;
  publish::Publisher& publisher;
  publish::Subscriptions subscriptions;
  std::array<publish::Bundle, publish::Subscriptions::kBundleCount> bundles{
      publish::Bundle(subscriptions.bundle(publish::Subscriptions::kRigBundle)),
      publish::Bundle(subscriptions.bundle(publish::Subscriptions::kCanonicalBundle)),
      publish::Bundle(subscriptions.bundle(publish::Subscriptions::kSourceBundle))};
  Layers layers;
  Roster roster;
  Commands commands;
  Takes takes;
  decide::Decider decider;
  decide::Overload overload;
  Stages stages;
  EventLog events;
  log::Log log;
};

}  // namespace styled::pipeline
