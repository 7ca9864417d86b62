#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "model/base/status.h"
#include "proto/recording/reader.h"
#include "proto/recording/writer.h"
#include "proto/styled/v1/body.pb.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled::golden {

// The frames that the pipeline publishes for a recording of the daemon.
struct Played {
  std::map<std::string, std::vector<v1::Frame>> frames;  // by topic
  std::vector<v1::Body> bodies;                          // each different body once
  std::map<std::string, std::uint64_t> counters;         // of source.*, pipeline.* and stylist.*
};

struct Options {
  bool commands = true;  // false: ignore the recorded commands, so nothing is styled
};

// Plays a recording through translators and pipeline, configured like the daemon in the recording's
// header, with the weights at `weights`. The recorded times drive the clock, so a replay takes
// milliseconds and always gives the same result: no sockets, no threads, no sleep. Errors: the
// configuration, the weights, a source that is not in the configuration.
Result<Played> Replay(recording::Reader& reader, const std::string& weights,
                      const Options& options = {});

}  // namespace styled::golden
