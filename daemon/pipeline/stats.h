#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/perform/merge/layers.h"
#include "daemon/perform/roster.h"
#include "daemon/perform/stages.h"
#include "daemon/pipeline/dependencies.h"
#include "daemon/publish/subscriptions.h"
#include "daemon/source/transport.h"
#include "proto/styled/v1/control.pb.h"
#include "proto/styled/v1/stats.pb.h"

namespace styled::pipeline {

// The daemon's statistics: topic "stats/" once a second, and StatusReply. Pipeline thread;
// allocates except in NoteCycle.
class Stats {
 public:
  using Transports = std::vector<std::unique_ptr<source::Transport>>;

  // All arguments must outlive it.
  Stats(const Dependencies& dependencies, const Roster& roster, const Layers& layers,
        const Transports& transports, Stages& stages, publish::Subscriptions& subscriptions);
  Stats(const Stats&) = delete;  // its topic is registered
  Stats& operator=(const Stats&) = delete;

  // The configured types, by source. Call before the first request.
  void SetSourceTypes(std::vector<std::string> types) { source_types_ = std::move(types); }
  // Call after a cycle of the pipeline that did something; it took `cycle_ns`.
  void NoteCycle(std::int64_t cycle_ns) noexcept;

  void Fill(v1::StatusReply& status) const;
  std::int64_t due_ns() const { return due_ns_; }
  // Begins the next second, and publishes the last one's statistics if a client subscribes.
  void Publish();

 private:
  void Fill(v1::Stats& stats) const;
  void DescribeClock(v1::ClockState& clock) const;
  void DescribeStandby(v1::StandbyState& state) const;
  void DescribeSource(std::size_t index, v1::SourceInfo& info) const;

  Dependencies dependencies_;
  const Roster& roster_;
  const Layers& layers_;
  const Transports& transports_;
  Stages& stages_;
  std::vector<std::string> source_types_;
  publish::Topic topic_{"stats/"};
  std::int64_t started_ns_, due_ns_;
  std::int64_t longest_cycle_ns_ = 0;
  std::string bytes_;
};

}  // namespace styled::pipeline
