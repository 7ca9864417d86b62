#pragma once

#include <sys/epoll.h>

#include <atomic>
#include <cstdint>
#include <span>

#include "daemon/pipeline/worker.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/descriptor.h"
#include "daemon/runtime/wakeup.h"

namespace styled::pipeline {

// How a thread waits for what is next.
enum class Wait : std::uint8_t {
  kBlock,   // asleep
  kHybrid,  // asleep, but awake while a frame is expected
  kBusy,    // awake: takes a core for itself
};

// The thread of the pipeline: waits for transports, subscribers, commands or the next deadline, and
// calls DoWork until there is nothing to do. Run() returns after Stop().
class PipelineThread {
 public:
  // `wake` is one of the descriptors waited for, cleared when it fires; so are `fds`.
  PipelineThread(Worker& worker, std::span<const int> fds, runtime::Wakeup& wake,
                 const runtime::Clock& clock, Wait wait);
  void Run();
  void Stop();  // any thread
  // Turns of the loop so far: whoever wakes the thread and sees no more of them knows that it
  // hangs. Any thread.
  std::uint64_t turns() const { return turns_.load(std::memory_order_relaxed); }

 private:
  void Watch(int fd);
  int Sleep(std::int64_t wait_ns, std::span<epoll_event> events);

  bool StaysAwake() const;

  Worker& worker_;
  runtime::Wakeup& wake_;
  const runtime::Clock& clock_;
  Wait mode_;
  runtime::Descriptor epoll_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> turns_{0};
};

}  // namespace styled::pipeline
