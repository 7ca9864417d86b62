#pragma once

#include <sys/types.h>

#include <string>

namespace styled::support {

// Stops one thread of another process as a debugger does (ptrace), while all others run on: no
// signal can do that, and the process need not know of it. Runs on when this is destroyed. Create
// and destroy it on one thread.
class FrozenThread {
 public:
  // The thread of `pid` that is called `name`. Not frozen() where there is none or ptrace is not
  // allowed here; error() says why.
  FrozenThread(pid_t pid, const std::string& name);
  ~FrozenThread();
  FrozenThread(const FrozenThread&) = delete;
  FrozenThread& operator=(const FrozenThread&) = delete;

  bool frozen() const { return frozen_; }
  const std::string& error() const { return error_; }
  // Waits until the process is killed. A killed thread is gone only once its tracer has looked.
  void AwaitDeath();

 private:
  pid_t thread_ = 0;
  bool frozen_ = false;
  std::string error_;
};

}  // namespace styled::support
