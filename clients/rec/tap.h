#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "clients/cpp/curve.h"
#include "model/base/status.h"
#include "proto/recording/writer.h"

namespace styled::rec {

struct TapOptions {
  std::vector<std::string> endpoints;  // of publishers
  std::vector<std::string> topics;     // prefixes; empty: all
  std::string performer;               // the performer of `topics`, if they belong to one
  double seconds = 0;                  // 0: until stopped
  std::optional<client::Curve> curve;  // for publishers that require keys
};

constexpr double kPatience_s = 3;

struct TapCounts {
  std::uint64_t messages = 0;
  std::uint64_t statistics = 0;  // of those, on stats/
  std::uint64_t missed = 0;      // frames lost in transit, by gaps in `sequence`
  std::uint64_t odd = 0;         // skipped: messages that are not topic and payload
};

// Subscribes to daemons and records their messages, each frame once. If no daemon listens there
// yet, it waits. One thread.
class Tap {
 public:
  // Refuses an endpoint that ZeroMQ cannot parse, and invalid keys.
  static Result<std::unique_ptr<Tap>> Connect(const TapOptions& options);
  ~Tap();
  Tap(const Tap&) = delete;
  Tap& operator=(const Tap&) = delete;

  // Runs until `stop` is set or TapOptions::seconds have passed. Writes a line to `err` at the
  // first message, and once if nothing arrived within kPatience_s, or nothing of the performer.
  Status Run(recording::FileWriter& writer, const std::atomic<bool>& stop, std::ostream& err);
  const TapCounts& counts() const;
  // "there are rig.anna, rig.ben": the performers in the received statistics.
  std::string ListPerformers() const;

 private:
  struct Impl;
  explicit Tap(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// The topics of one performer.
std::vector<std::string> TopicsOf(const std::string& performer);

}  // namespace styled::rec
