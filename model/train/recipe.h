#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/base/status.h"

namespace styled::train {

struct Checkpoint;

// Figures with their names, in a fixed order: columns of a CSV file.
using Figures = std::vector<std::pair<std::string, double>>;

// Figures of a run's present weights on fixed validation windows.
struct MonitorReport {
  Figures figures;      // the columns of monitor.csv after iteration and elapsed_s
  std::string summary;  // the same for the terminal, one line without its end
};

// The training of one network family, as the trainer drives it: networks, losses, optimizers and
// the order of the data. The trainer (model/train/trainer.h) adds clock, log, checkpoints, resume
// and validation, and knows no network; a further family implements this interface and gets a row
// in the table of model/tools/styletrain.cpp.
//
// A recipe is made for one run, from its flags and its data, with everything in place that does not
// depend on the starting point. Calls come from one thread, in this order: Start or Restore, once;
// then Step, and between steps any of the others. Errors that the user can fix are a Status whose
// message names the flag or the file. Any function may also throw libtorch's exceptions (a
// std::exception); the trainer ends the run with its message, and the last checkpoint stays.
//
// Given the same flags, data and seed, the iterations after Restore on a CPU must be bit for bit
// those that would have followed Save: everything that the next Step depends on is in the
// checkpoint, or is seeded by the iteration. Pinned by tests/unit/train/run_test.cpp.
class Recipe {
 public:
  virtual ~Recipe() = default;

  // The family's name in flags, checkpoints and weights files, such as "style-erd"; constant.
  virtual std::string_view family() const = 0;

  // Begins a new run: initial weights, and any training before the first iteration. May take
  // minutes and print progress to stdout.
  virtual Status Start() = 0;

  // One iteration on the next batch. `progress` in [0, 1] is the share of the run that is over, by
  // iterations or by time; schedules depend on it alone.
  virtual void Step(double progress) = 0;
  // Completed iterations, counted by Step and restored by Restore.
  virtual int64_t iteration() const = 0;

  // The named losses, means over the `iterations` (at least 1) since the last call, which starts
  // new sums. The columns of log.csv after iteration, elapsed_s and progress; unweighted, so that
  // runs with different weights can be compared. Waits for the device.
  virtual Figures PopLosses(int iterations) = 0;
  // False if a trained parameter is infinite or not a number. Waits for the device.
  virtual bool Finite() const = 0;
  virtual MonitorReport Monitor() const = 0;

  // Adds to `checkpoint` all tensors and optimizer states that the next Step depends on, and those
  // that ExportWeights needs. `wall_time_s`: of the run until now, for the metadata of the weights.
  // Tensors may share memory with the recipe's: the checkpoint must be written before the next
  // Step. Names of the trainer's own (model/train/checkpoint.h) are reserved.
  virtual void Save(double wall_time_s, Checkpoint& checkpoint) const = 0;
  // Continues where Save was called. Refuses a checkpoint of other data or of another batch size;
  // the recipe is then unusable. `checkpoint` is of this family.
  virtual Status Restore(const Checkpoint& checkpoint) = 0;

  // Writes the weights file that the family's runtime loads (model/net) from the content that Save
  // added to `checkpoint`; atomically. A validation judges this file, too.
  virtual Status ExportWeights(const Checkpoint& checkpoint,
                               const std::filesystem::path& file) const = 0;
};

}  // namespace styled::train
