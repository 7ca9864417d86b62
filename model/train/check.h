#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "model/base/status.h"
#include "model/train/trainer.h"

// Checks the input of a run before it begins, and reports all errors at once, not one per attempt.
// Needs no libtorch.
namespace styled::train {

// The requirements of a family and the flags for clips and files.
struct Needs {
  double rate_hz = 30;    // of the network
  int train_frames = 25;  // the fewest that a clip needs at that rate for training
  int window_frames = 25;
  bool paired = false;  // a style is learnt in contents that neutral has, too
  // Flags that name files to read: {"--init", "v2.safetensors"}.
  std::vector<std::pair<std::string, std::filesystem::path>> files;
  std::filesystem::path judges;  // folder of --validate; empty: the run is not judged
  int judge_frames = 32;         // window of the judges, at 30 Hz
};

// The clips of one style.
struct StylePlan {
  std::string style;
  struct Part {
    int clips = 0,
        too_short = 0;   // too short: fewer frames than its split needs; they are left out
    double seconds = 0;  // of the others
  } train, judge, validation;
  long windows = 0;  // in training, by where they can start, mirror images not counted
};

struct Plan {
  // A sentence each, with the flag, or file and line, what was found and what was expected.
  std::vector<std::string> wrong;
  // Warnings: the run works, but probably not as intended.
  std::vector<std::string> doubtful;
  std::vector<StylePlan> styles;  // as in the manifest, neutral first; empty if it cannot be read
};

// Reads the manifest and all of its clips. Leaves nothing behind: missing folders are not created;
// whether they could be is tested with a temporary one. Blocks for as long as the clips take to
// read; one thread. Pinned by tests/unit/train/check_test.cpp.
Plan CheckBeforeTraining(const RunConfig& run, const Needs& needs);

// For people: a table of the styles, several lines.
std::string PlanText(const Plan& plan, const Needs& needs);

}  // namespace styled::train
