#pragma once

#include <chrono>
#include <string>

#include "model/base/status.h"
#include "model/train/recipe.h"
#include "model/train/trainer.h"

// The speed of a run, measured in its first seconds, and the resulting estimate for the rest.
namespace styled::train {

// Measures the time of iterations. The first ones, in which memory is allocated and caches are
// cold, are left out.
class PaceMeter {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr int kSkipped = 3;  // iterations
  static constexpr int kFewest = 10;  // measured iterations, and at least this long:
  static constexpr std::chrono::seconds kShortest{3};

  // Call after each iteration with the present time. Returns true once, when the measurement is
  // complete.
  bool AfterIteration(Clock::time_point now);
  double per_minute() const { return per_minute_; }

 private:
  Clock::time_point begin_;
  int iterations_ = 0;
  double per_minute_ = 0;  // 0: not known yet
};

// The most memory that this process has had so far, MB; 0 if the system does not report it.
long PeakMemory_mb();

// "1020 iterations a minute, 412 MB of memory; 20 minutes are some 20400 iterations; ...".
std::string PaceText(const RunConfig& run, bool validated, double per_minute, long memory_mb);

// Starts `recipe` and runs its first iterations until the pace is known, prints the pace to stdout,
// and writes nothing. The recipe cannot be used afterwards. Errors are those of Recipe::Start.
// Blocks for as long as that takes.
Status MeasureOnly(const RunConfig& run, bool validated, Recipe& recipe);

}  // namespace styled::train
