#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "model/train/judge/clip_restyler.h"
#include "model/train/judge/data.h"

namespace styled::judge {

// A performer who walks, turns, waves and runs without a pause: neutral validation clips, each at
// most 128 frames of it, blended over half a second. If the manifest lacks these contents, all that
// it has in turn. Poses at kJudgeRate_hz; empty if every clip is too short.
struct MixedClip {
  Poses poses;
  struct Segment {
    int content = 0;
    std::size_t begin = 0, end = 0;  // frames without the blends
  };
  std::vector<Segment> segments;
};
inline constexpr std::size_t kMixedFrames = 1000;
MixedClip MakeMixed(const Data& data, std::size_t frames = kMixedFrames);

// A recorded clip (poses at kJudgeRate_hz) by a code, at that rate.
Poses RestyleRecorded(const ClipRestyler& restyler, const Poses& clip, const net::StyleCode& code);

// Recognition of each act within the mixed clip, styled as a whole by one code, and of the same
// frames styled alone; over the mean code of every style.
struct ActRecognition {
  Mean style, content;  // share of windows
};
struct MixedFigures {
  struct Act {
    ActRecognition mixed, alone, offset;  // offset: the constant one, on the same frames
    Mean content_of_input;                // share of the input's windows
  };
  std::vector<Act> acts;  // by content
  double seconds = 0;
};
MixedFigures MeasureMixed(const Data& data, const Judges& judges, const ClipRestyler& restyler);
void Print(const clip::Manifest& manifest, const MixedFigures& figures);
nlohmann::json ToJson(const clip::Manifest& manifest, const MixedFigures& figures);

}  // namespace styled::judge
