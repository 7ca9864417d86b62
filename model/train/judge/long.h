#pragma once

#include <vector>

#include "model/train/judge/data.h"
#include "model/train/judge/stream.h"

namespace styled::judge {

// A long stream of neutral clips, of one content or of all in turn, and its output in every style.
// The stream lasts `seconds` and then shows each clip once more.
struct LongRun {
  Chain chain;                // at the stream's rate
  std::vector<int> contents;  // of each clip of the chain
  std::vector<Poses> styled;  // per manifest style; empty where absent
};

// One run per content of `data.validation`, and a last one of all contents mixed.
std::vector<LongRun> RunLong(const Data& data, const Styler& styler,
                             const stylist::Options& options, double seconds);

// Cuts out the clips of the long runs that begin after `seconds`, without the seams. Spans in the
// result point into `runs`.
std::vector<Transferred> CutLate(std::span<const LongRun> runs, double seconds);

}  // namespace styled::judge
