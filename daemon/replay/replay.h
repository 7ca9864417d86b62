#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/runtime/counters.h"
#include "model/base/status.h"
#include "proto/recording/reader.h"

namespace styled::replay {

struct Options {
  std::string subscription;  // publishes the topics that begin with this
  bool commands = true;      // execute the recorded commands again
  // Performs the decisions of the daemon that made the recording (recording::Decided), as a standby
  // performs its leader's: the same frames are published, late, skipped or without style, under the
  // same numbers. Otherwise, and where the recording has no decision, frames are decided again, as
  // on a machine that is always in time.
  bool decided = false;
  std::vector<pipeline::Profile> profiles;  // the settings in force at the beginning
};

// Receives a published message; `time_ns` is on the recording's clock. The topic `stats/` is left
// out, because it describes this machine.
using Sink = std::function<void(std::int64_t time_ns, std::string_view topic,
                                std::span<const std::byte> payload)>;

// The configuration of the daemon that made the recording, from its header. The header's copy of
// that daemon's command line is only a comment: pass settings as `overrides`. Errors name the
// recording, line and key.
Result<config::Config> ConfigOf(const recording::Reader& reader,
                                const std::vector<config::Override>& overrides);

// Plays the recorded arrivals and commands in order through translators and pipeline, as a daemon
// with `config` and `runtime_config` would. The recorded times drive the clock: there are no
// sockets, threads or sleeps, and every run gives the same result for every rig. `counters` shows
// the fate of the frames. Allocates; one thread. Errors: nothing arrived, or data arrived from a
// source that is not in the configuration.
Status Replay(recording::Reader& reader, const config::Config& config,
              const std::shared_ptr<const pipeline::RuntimeConfig>& runtime_config,
              const Options& options, runtime::Counters& counters, const Sink& sink);

// Whether a counter describes the frames, and not the machine or the daemon's peers.
bool IsOfTheMotion(runtime::Counter counter);

// Implements `styled --replay`: writes the published messages to a new recording, `file`. Returns a
// text with duration, number of messages and counters, and a warning if the recording was made with
// other weights.
Result<std::string> ReplayToFile(recording::Reader& reader, const config::Config& config,
                                 const std::string& file, bool decided = false);

}  // namespace styled::replay
