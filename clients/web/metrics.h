#pragma once

#include <cstdint>
#include <string>

#include "proto/styled/v1/stats.pb.h"

namespace styled::web {

// Counters of the gateway since its start.
struct Counters {
  std::uint64_t connections = 0;     // accepted
  std::uint64_t refused_full = 0;    // closed at once: limit reached
  std::uint64_t refused_access = 0;  // replies 400, 401, 403
  std::uint64_t gave_way = 0;        // unfinished, closed to make room for a new connection
  std::uint64_t browsers = 0;        // WebSockets opened
  std::uint64_t sent_messages = 0;   // to browsers
  std::uint64_t sent_bytes = 0;
  std::uint64_t superseded = 0;         // replaced by a newer one while the browser did not read
  std::uint64_t requests = 0;           // control requests from browsers
  std::uint64_t unanswered = 0;         // ... without a reply of the daemon
  std::uint64_t bad_messages = 0;       // from browsers
  std::uint64_t upstream_messages = 0;  // from the daemon
  std::uint64_t upstream_malformed = 0;
};

// Current values.
struct Gauges {
  bool daemon_up = false;
  std::uint64_t browsers = 0, connections = 0;
  std::uint64_t subscriptions = 0;  // distinct topics subscribed at the daemon
};

// The metrics in Prometheus' exposition format 0.0.4. `daemon`: its last Stats; null while it is
// down. Allocates.
std::string PrometheusText(const Counters& counters, const Gauges& gauges, const v1::Stats* daemon);

}  // namespace styled::web
