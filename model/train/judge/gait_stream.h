#pragma once

#include <optional>
#include <vector>

#include "model/train/judge/gaits.h"
#include "model/train/judge/live_restyler.h"

namespace styled::judge {

// The state of the performer's neutral in the stylist when a clip begins.
enum class NeutralKnown {
  kCalibrated,  // what it learned from another clip of theirs; it no longer changes
  kLearned,     // what it learned in kLearning_s of the same clip, which precede it
  kMean,        // nothing, ever: they count as the network's own performers
};
inline constexpr double kLearning_s = 3.0;

// A clip and its styled form, at kJudgeRate_hz, frame for frame, without the first kSettling
// frames.
struct InAndOut {
  Poses input, output;
};

// Walks and runs through a live network by codes. The same frames of a clip count whatever is
// known. Pinned by tests/unit/judge/gaits_test.cpp.
class GaitStream {
 public:
  // Refers to `styler` and `sources`, which must remain. kCalibrated: every person has two clips.
  GaitStream(const Styler& styler, const std::vector<GaitSource>& sources, NeutralKnown known);

  InAndOut Style(std::size_t source, const net::StyleCode& code) const;

 private:
  const std::vector<GaitSource>& sources_;
  NeutralKnown mode_;
  LiveRestyler restyler_;
  std::vector<neutral::Known> known_;  // by source; only of kCalibrated
};

// The first `seconds` of a clip, and after them the clip as a whole, blended into one another.
// `begin`: where it is frame for frame the clip again, turned and moved, but for the blend's
// frames.
struct LedIn {
  Poses poses;
  std::size_t begin = 0;
};
LedIn WithLeadIn(const Poses& clip, double seconds);

}  // namespace styled::judge
