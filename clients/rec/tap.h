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
  std::vector<std::string> topics;     // prefixes; empty: everything
  std::string performer;               // whose topics they are, where they are one's
  double seconds = 0;                  // 0: until stopped
  std::optional<client::Curve> curve;  // for publishers that ask for keys
};

constexpr double kPatience_s = 3;

struct TapCounts {
  std::uint64_t messages = 0;
  std::uint64_t statistics = 0;  // of those, on stats/
  std::uint64_t missed = 0;      // frames lost on the way here, by their sequences
  std::uint64_t odd = 0;         // messages that are not topic and payload; left out
};

// Subscribes to daemons and records what they publish. That nobody listens there is no error: it
// waits. One thread.
class Tap {
 public:
  // Refuses an endpoint that ZeroMQ cannot parse, keys that are none.
  static Result<std::unique_ptr<Tap>> Connect(const TapOptions& options);
  ~Tap();
  Tap(const Tap&) = delete;
  Tap& operator=(const Tap&) = delete;

  // Until `stop` is set or the options' seconds are over. `err` is told when the first message
  // came, and once when after kPatience_s nothing came, or nothing of the performer.
  Status Run(recording::FileWriter& writer, const std::atomic<bool>& stop, std::ostream& err);
  const TapCounts& counts() const;
  // "there are rig.anna, rig.ben": whom the statistics that came speak of.
  std::string WhoIsThere() const;

 private:
  struct Impl;
  explicit Tap(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// The topics of one performer.
std::vector<std::string> TopicsOf(const std::string& performer);

}  // namespace styled::rec
