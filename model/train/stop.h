#pragma once

namespace styled::train {

// While it lives, the first SIGINT or SIGTERM asks the run to end after the current step, and
// prints that on standard error; the second one ends the process at once, as without it. One at a
// time; its destructor restores the former handlers. Pinned by tests/unit/train/stop_test.cpp.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;
};

// The signal that was received, 0 if none since the last StopOnSignal began. Any thread.
int StopSignal() noexcept;

}  // namespace styled::train
