#pragma once

#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"

namespace styled::parity {

// The mix from frame `first_frame` on; the weights change at once, without a fade.
struct Segment {
  int first_frame = 0;
  std::vector<std::pair<std::string, float>> mix;  // style names and weights
};

// One style; a mix of two that leaves a share to neutral and keeps the first's branch live; a
// switch to a third; and a mix whose weights sum to more than 1.
inline constexpr const char* kSchedule =
    "0:elderly=1;300:elderly=0.5,youthful=0.3;600:masculine=1;800:feminine=0.8,active=0.6";

// Reads "FRAME:STYLE=WEIGHT,...;FRAME:...", with frames increasing from 0. Errors quote the bad
// part.
Result<std::vector<Segment>> ParseSchedule(const std::string& text);

// The segment in effect at a frame; `schedule` is ParseSchedule's result.
const Segment& SegmentAt(const std::vector<Segment>& schedule, int frame);

}  // namespace styled::parity
