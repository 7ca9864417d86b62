#pragma once

#include <chrono>
#include <string>

#include "model/base/status.h"
#include "model/train/recipe.h"
#include "model/train/trainer.h"

// How fast a run is, measured in its first seconds, and what that means for the rest of it.
namespace styled::train {

// Measures the time of iterations: the first ones, in which memory is allocated and caches are
// cold, are left out.
class PaceMeter {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr int kSkipped = 3;  // iterations
  static constexpr int kFewest = 10;  // measured iterations, and at least for so long:
  static constexpr std::chrono::seconds kShortest{3};

  // Call after each iteration with the present time. True when it has enough, once.
  bool AfterIteration(Clock::time_point now);
  double per_minute() const { return per_minute_; }

 private:
  Clock::time_point begin_;
  int iterations_ = 0;
  double per_minute_ = 0;  // 0: not known yet
};

// The most memory that this process has had so far, MB; 0 where the system does not say.
long PeakMemory_mb();

// "1020 iterations a minute, 412 MB of memory; 20 minutes are some 20400 iterations; ...".
std::string PaceText(const RunConfig& run, bool validated, double per_minute, long memory_mb);

// Starts `recipe` and runs its first iterations until the pace is known, prints the pace to stdout,
// and writes nothing. The recipe is then used up. Errors are those of Recipe::Start. Blocks for as
// long as that takes.
Status MeasureOnly(const RunConfig& run, bool validated, Recipe& recipe);

}  // namespace styled::train
