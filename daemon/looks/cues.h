#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "model/base/status.h"
#include "model/net/styles.h"
#include "proto/styled/timecode.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

// One [[cue]]: the request it executes, and its timecode.
struct Cue {
  std::string name;
  std::optional<std::int64_t> at;  // TimecodeLabel
  std::string performer;           // an id, or "*"
  v1::Request request;             // for performer "*", without a performer
};

// HH:MM:SS:FF as a number that increases with the timecode, whatever its rate.
std::int64_t TimecodeLabel(const Timecode& timecode) noexcept;
std::string TimecodeText(std::int64_t label);
// Parses "01:02:03:04", or with ';' before the frames; empty for other texts.
std::optional<Timecode> ParseTimecode(std::string_view text);

// Returns whether a performer's timecode passed `at` between two of its frames. A step of more than
// two seconds, or backward, is winding of the tape and passes nothing. The first timecode of a
// performer (`last` is empty) passes only the cue at exactly that timecode: a show may begin with a
// cue.
bool Passes(std::int64_t at, std::optional<std::int64_t> last, std::int64_t now) noexcept;

// Errors name the place, the key and what was expected; styles and presets must exist. Start-up and
// reload only; allocates.
Result<Cue> MakeCue(const config::Cue& cue, const std::vector<config::Preset>& presets,
                    const net::Styles& styles);

}  // namespace styled::pipeline
