#include "model/train/measure.h"

#include <sys/resource.h>

#include <cmath>
#include <exception>
#include <iostream>
#include <sstream>

#include "model/base/text.h"
#include "model/train/checkpoint.h"

namespace styled::train {

bool PaceMeter::AfterIteration(Clock::time_point now) {
  if (per_minute_ > 0) return false;
  if (++iterations_ == kSkipped) begin_ = now;
  const int measured = iterations_ - kSkipped;
  if (measured < kFewest || now - begin_ < kShortest) return false;
  per_minute_ = 60.0 * measured / std::chrono::duration<double>(now - begin_).count();
  return true;
}

long PeakMemory_mb() {
  struct rusage usage {};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return usage.ru_maxrss / 1024;  // it is in KiB
}

std::string PaceText(const RunConfig& run, bool validated, double per_minute, long memory_mb) {
  std::ostringstream text;
  text << std::llround(per_minute) << " iterations a minute, " << memory_mb << " MB of memory";
  if (run.minutes > 0) {
    text << "; " << NumberText(run.minutes) << " minutes are some "
         << std::llround(run.minutes * per_minute) << " iterations";
  }
  if (run.iterations > 0) {
    text << "; " << run.iterations << " iterations take some "
         << NumberText(static_cast<double>(run.iterations) / per_minute, 1) << " minutes";
  }
  if (validated) {
    text
        << "; the first validation is after " << NumberText(run.validate_minutes)
        << " minutes; before the run judges are trained, once for these clips, with their own time";
  }
  return text.str();
}

Status MeasureOnly(const RunConfig& run, bool validated, Recipe& recipe) {
  try {
    const Status started = recipe.Start();
    if (!started.ok()) return started;
    PaceMeter meter;
    do {
      recipe.Step(0);
    } while (!meter.AfterIteration(PaceMeter::Clock::now()));
    std::cout << "measured: " << PaceText(run, validated, meter.per_minute(), PeakMemory_mb())
              << std::endl;
    return Status::Ok();
  } catch (const std::exception& failure) {
    return Status::Error(std::string("libtorch: ") + Reason(failure));
  }
}

}  // namespace styled::train
