#pragma once

#include <sys/epoll.h>

#include <atomic>
#include <cstdint>
#include <span>

#include "daemon/pipeline/pipeline.h"
#include "daemon/runtime/descriptor.h"

namespace styled::pipeline {

// The thread of the pipeline: waits in epoll for transports, subscribers, commands or the next
// deadline, and calls DoWork until there is nothing to do. Run() returns after Stop().
class PipelineThread {
 public:
  PipelineThread(Pipeline& pipeline, publish::Publisher& publisher, Mailboxes& mailboxes,
                 const runtime::Clock& clock);
  void Run();
  void Stop();  // any thread
  // Turns of the loop so far: whoever wakes the thread and sees no more of them knows that it
  // hangs. Any thread.
  std::uint64_t turns() const { return turns_.load(std::memory_order_relaxed); }

 private:
  void Watch(int fd);
  int Wait(std::int64_t wait_ns, std::span<epoll_event> events);

  Pipeline& pipeline_;
  Mailboxes& mailboxes_;
  const runtime::Clock& clock_;
  runtime::Descriptor epoll_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> turns_{0};
};

}  // namespace styled::pipeline
