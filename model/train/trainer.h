#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "model/base/status.h"
#include "model/train/recipe.h"

namespace styled::train {

// The flags of styletrain that every run has, whatever its network. A family's own are beside its
// recipe (model/train/erd/config.h).
struct RunConfig {
  std::filesystem::path manifest, data, out;
  std::string command;  // recorded in the metadata of the weights
  // The run ends at the first of these limits. minutes: wall time over all resumes. 0: no limit;
  // one of them must be above 0.
  double minutes = 0;
  int64_t iterations = 0;
  int64_t stop_at = 0;  // ends this session at that iteration, the run's length unchanged; 0: no
  uint64_t seed = 1;
  bool resume = false;          // continues the run in `out`; the other flags must be the same
  std::string device = "auto";  // "auto" (CUDA where there is a device), "cpu" or "cuda"
  int threads = 1;              // of libtorch

  double checkpoint_minutes = 5.0;  // between checkpoints; a crash costs at most this part of a run
  int log_every = 100, monitor_every = 500;  // iterations
  double validate_minutes = 10.0;            // between validations, where there are any
  int patience = 0;  // the run ends after this many validations without a better score; 0: never
};

// The judge of a run: named figures of a weights file. The first is the score, higher is better.
using Validate = std::function<Result<Figures>(const std::filesystem::path& weights)>;

// Refuses flags that cannot work: no length, a negative or infinite time, a folder without data, a
// CUDA device that libtorch does not find. Errors name the flag. Creates `out`.
Status CheckRun(const RunConfig& run);

// Makes a family's recipe. `flags` is the result of the family's check of its own flags; an error
// in it is reported before CheckRun, and both before `make`, which may read data. Exceptions of
// `make` become errors, too.
Result<std::unique_ptr<Recipe>> MakeChecked(
    const RunConfig& run, const Status& flags,
    const std::function<Result<std::unique_ptr<Recipe>>()>& make);

// Runs `recipe` until iterations or minutes are over. Writes into `out`: checkpoint.pt and
// weights.safetensors (both replaced atomically, at every checkpoint), log.csv, monitor.csv; with
// `validate` also validation.csv and its picture curve.svg, and best.safetensors, the weights of
// the best score so far. Prints progress to stdout. A resumed run continues where the checkpoint
// was made, on a CPU bit for bit. SIGINT and SIGTERM end a session after its step, saved (stop.h).
// Errors name file or iteration. Blocks; one thread. Pinned by tests/unit/train/trainer_test.cpp,
// run_test.cpp.
Status Train(const RunConfig& run, Recipe& recipe, const Validate& validate = nullptr);

// A family's Recipe::ExportWeights without a run.
using ExportFunction = Status (*)(const Checkpoint& checkpoint, const std::filesystem::path& file);

// Writes the weights of the run in the folder `run`. `find` returns the export of a family by its
// name, null if it is unknown. Errors name the checkpoint or the file.
Status ExportRun(const std::filesystem::path& run, const std::filesystem::path& file,
                 const std::function<ExportFunction(const std::string& family)>& find);

}  // namespace styled::train
