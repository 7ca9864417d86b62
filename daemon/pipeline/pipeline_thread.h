#pragma once

#include <sys/epoll.h>

#include <atomic>
#include <cstdint>
#include <span>

#include "daemon/pipeline/worker.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/wakeup.h"
#include "model/base/descriptor.h"

namespace styled::pipeline {

// How a thread waits for the next frame.
enum class Wait : std::uint8_t {
  kBlock,   // sleeps
  kHybrid,  // sleeps, but polls while a frame is expected
  kBusy,    // polls: occupies a core
};

// Runs the pipeline's thread: waits for transports, subscribers, commands or the next deadline, and
// calls DoWork until there is nothing to do. Run() returns after Stop().
class PipelineThread {
 public:
  // The thread waits for `wake` and `fds`; `wake` is cleared when it fires.
  PipelineThread(Worker& worker, std::span<const int> fds, runtime::Wakeup& wake,
                 const runtime::Clock& clock, Wait wait);
  void Run();
  void Stop();  // any thread
  // Number of turns of the loop so far. If it does not change after a wake-up, the thread hangs.
  // Any thread.
  std::uint64_t turns() const { return turns_.load(std::memory_order_relaxed); }

 private:
  void Watch(int fd);
  int Sleep(std::int64_t wait_ns, std::span<epoll_event> events);

  bool StaysAwake() const;

  Worker& worker_;
  runtime::Wakeup& wake_;
  const runtime::Clock& clock_;
  Wait mode_;
  Descriptor epoll_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> turns_{0};
};

}  // namespace styled::pipeline
