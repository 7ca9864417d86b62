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
  std::string subscription;                 // topics that begin like this are published
  bool commands = true;                     // give the recorded commands again
  std::vector<pipeline::Profile> profiles;  // the settings that held at the beginning
};

// A message of the publisher at `time_ns` on the recording's clock. `stats/` is left out: it tells
// of this machine.
using Sink = std::function<void(std::int64_t time_ns, std::string_view topic,
                                std::span<const std::byte> payload)>;

// The configuration of the daemon that made the recording, out of its header. Settings of a command
// line are not part of it: `overrides` are. Errors name the recording, line and key.
Result<config::Config> ConfigOf(const recording::Reader& reader,
                                const std::vector<config::Override>& overrides);

// Plays what arrived, and which commands fell where, through translators and pipeline as the daemon
// of `config` with `runtime_config` would. The recorded times drive the clock: no sockets, no
// threads, no sleep, and the same at every run, for every rig. `counters` tells what became of the
// frames. Allocates; one thread. Errors: nothing arrived, or from a source that is not in the
// configuration.
Status Replay(recording::Reader& reader, const config::Config& config,
              std::shared_ptr<const pipeline::RuntimeConfig> runtime_config, const Options& options,
              runtime::Counters& counters, const Sink& sink);

// Whether a counter tells of the frames, and not of the machine or the daemon's peers.
bool IsOfTheMotion(runtime::Counter counter);

// All of `styled --replay`: what is published goes to a new recording, `file`. Returns a line that
// says what was played.
Result<std::string> ReplayToFile(recording::Reader& reader, const config::Config& config,
                                 const std::string& file);

}  // namespace styled::replay
