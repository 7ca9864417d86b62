#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "model/train/dataset.h"
#include "model/train/judge/metrics.h"
#include "model/train/judge/stream.h"

namespace styled::judge {

// Styles by one example, judged on walks and runs by judges that never saw the example: the parts
// of the clips, and the figures. Poses at kJudgeRate_hz. Needs no libtorch. Pinned by
// tests/unit/judge/gaits_test.cpp.

enum class GaitKind { kWalk, kRun };
inline constexpr std::size_t kGaitKinds = 2;
inline constexpr std::array<const char*, kGaitKinds> kGaitNames{"walk", "run"};
template <typename T>
using PerGait = std::array<T, kGaitKinds>;

// Walks and runs are separated here: mean speed of the hips over the floor, canonical m/s.
inline constexpr double kRunsFrom_mps = 2.0;
GaitKind GaitOf(std::span<const body::Pose> poses);

// How SplitGaits cuts. One take of each style and content is the rule, so the parts are of one
// take.
struct GaitSplitting {
  std::size_t example = 90;   // the fewest frames of a walk that are the example: 3 s
  std::size_t least = 33;     // frames of a part: a window of the judges, and one for its velocity
  int fold = 0;               // 0 or 1: which half is the judges', and which is real
  bool leak = false;          // the judges learn from the examples, too
  bool example_runs = false;  // the whole run is an example, too; dashes alone are judged then
};

// A part of a style's gait that neither its example nor the judges contain.
struct RealPart {
  int style = 0;
  GaitKind gait = GaitKind::kWalk;
  std::string content;
  Poses poses;
};
struct GaitParts {
  std::vector<PerGait<Poses>> examples;     // by style; of neutral, the whole clips
  std::vector<train::TrainingClip> judges;  // what the judges learn from
  std::vector<RealPart> real;
  // By style: what the movement of outputs is compared with. Of walks the example, of runs the
  // judges' half of the longest run (the example with `example_runs`).
  std::vector<PerGait<Poses>> wanted;
};

// Cuts whole clips. `contents` are the names by TrainingClip::content: "walk", "run" and "dash" are
// gaits.
//   walk       the first `example` frames, or the first third where that is more: the example. The
//              rest is halved: one half is the judges', the other is real. A rest too short for two
//              parts is the judges' in fold 0, and real in fold 1.
//   run, dash  halved in the same way, without an example
//   others     the judges'; all of neutral, too
GaitParts SplitGaits(const std::vector<train::TrainingClip>& clips, std::size_t styles,
                     const std::vector<std::string>& contents, const GaitSplitting& splitting);
// Frames [first, end) of a clip.
train::TrainingClip Cut(const train::TrainingClip& clip, std::size_t first, std::size_t end);

// A clip to be styled, by a performer who shows no style.
struct GaitSource {
  std::string name, person;
  GaitKind gait = GaitKind::kWalk;
  Poses poses;
};
// Another clip of a source's person from which their neutral is learned: the next of the same gait,
// else the next of the other; -1 if there is none.
int NeutralSourceOf(std::span<const GaitSource> sources, std::size_t source);
// The same of one gait only.
int NeutralSourceOf(std::span<const GaitSource> sources, std::size_t source, GaitKind gait);
// All other walks of the person, one after the other; all other clips where there is no walk. Empty
// if there are none.
Poses MeanNeutralOf(std::span<const GaitSource> sources, std::size_t source);

// The figures of outputs in one style and gait; a figure without a count was not measured. Add
// accumulates clip by clip.
struct GaitFigures {
  Mean recognized, moves;  // share of windows: by the style judge; by the judge of movement alone
  Mean movement;           // distance from the wanted movement over the unstyled clip's
  Mean jerk;               // over the input's
  Mean skate_cm_s, input_skate_cm_s;

  void Add(const GaitFigures& other);
  // Each figure's mean as one clip.
  GaitFigures Once() const;
};
using GaitTable = std::vector<PerGait<GaitFigures>>;  // by style
// Of a table: the mean over the styles that have a figure; and over both gaits.
PerGait<GaitFigures> OverStyles(const GaitTable& table);
GaitFigures OverGaits(const PerGait<GaitFigures>& gaits);

// The distance between the movements of two clips about their mean poses (unseen_live.h), m.
double MovementDistance_m(const Poses& a, const Poses& b);

// Shares of a clip's windows that the judges take for one style.
struct Recognition {
  Mean style, movement;
};
// Of one output and its input, frame for frame, without their beginnings.
GaitFigures MeasureGaitOutput(const Poses& input, const Poses& output, const Poses& wanted,
                              const Recognition& recognition);
// Of a real part. `unchanged_m`: the unstyled clips' distance, 0 if not known.
GaitFigures MeasureReal(const RealPart& part, const Poses& wanted, double unchanged_m,
                        const Recognition& recognition);

}  // namespace styled::judge
