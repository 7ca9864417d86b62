#pragma once

#include <sys/types.h>

#include <string>

namespace styled::support {

// Stops one thread of another process through ptrace, as a debugger does, while its other threads
// run on. No signal can do that, and the process needs no support for it. The destructor resumes
// the thread. Construct and destroy it on the same thread.
class FrozenThread {
 public:
  // Stops the thread of `pid` named `name`. If there is none or ptrace is not permitted, frozen()
  // is false and error() returns the reason.
  FrozenThread(pid_t pid, const std::string& name);
  ~FrozenThread();
  FrozenThread(const FrozenThread&) = delete;
  FrozenThread& operator=(const FrozenThread&) = delete;

  bool frozen() const { return frozen_; }
  const std::string& error() const { return error_; }
  // Waits until the process is killed. A killed thread disappears only after its tracer has waited
  // for it.
  void AwaitDeath();

 private:
  pid_t thread_ = 0;
  bool frozen_ = false;
  std::string error_;
};

}  // namespace styled::support
