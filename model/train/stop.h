#pragma once

namespace styled::train {

// While it lives, the first SIGINT or SIGTERM asks the run to end after the step that is under way,
// and says so on standard error; the second one ends the process at once, as without it. One at a
// time; the handlers that were there come back at its end. Pinned by
// tests/unit/train/stop_test.cpp.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;
};

// The signal that asked, 0 if none did since the last StopOnSignal began. Any thread.
int StopSignal() noexcept;

}  // namespace styled::train
