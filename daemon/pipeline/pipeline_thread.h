#pragma once

#include <sys/epoll.h>

#include <atomic>
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

 private:
  void Watch(int fd);
  int Wait(std::int64_t wait_ns, std::span<epoll_event> events);

  Pipeline& pipeline_;
  Mailboxes& mailboxes_;
  const runtime::Clock& clock_;
  runtime::Descriptor epoll_;
  std::atomic<bool> stop_{false};
};

}  // namespace styled::pipeline
