#include "daemon/pipeline/pipeline_thread.h"

#include <sys/epoll.h>

#include <algorithm>
#include <array>

namespace styled::pipeline {

PipelineThread::PipelineThread(Pipeline& pipeline, publish::Publisher& publisher,
                               Mailboxes& mailboxes, const runtime::Clock& clock)
    : pipeline_(pipeline),
      mailboxes_(mailboxes),
      clock_(clock),
      epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  for (const auto& transport : pipeline.transports()) Watch(transport->fd());
  Watch(publisher.fd());
  Watch(mailboxes.wake_pipeline.fd());
}

void PipelineThread::Watch(int fd) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = fd;
  epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event);
}

void PipelineThread::Run() {
  std::array<epoll_event, 16> events;
  while (!stop_.load(std::memory_order_relaxed)) {
    if (pipeline_.DoWork() > 0) continue;
    const std::int64_t wait_ns = pipeline_.NextDeadline_ns() - clock_.Now_ns();
    const auto wait_ms = static_cast<int>(std::clamp<std::int64_t>(
        (wait_ns + runtime::kMillisecond_ns - 1) / runtime::kMillisecond_ns, 0, 1000));
    const int ready =
        epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), wait_ms);
    for (int i = 0; i < ready; ++i) {
      if (events[static_cast<std::size_t>(i)].data.fd == mailboxes_.wake_pipeline.fd()) {
        mailboxes_.wake_pipeline.Clear();
      }
    }
  }
}

void PipelineThread::Stop() {
  stop_.store(true, std::memory_order_relaxed);
  mailboxes_.wake_pipeline.Signal();
}

}  // namespace styled::pipeline
