#include "daemon/pipeline/pipeline_thread.h"

#include <sys/epoll.h>

#include <algorithm>
#include <array>
#include <cerrno>

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

// To the nanosecond where the kernel can (5.11): a delayed frame is not to leave a millisecond
// late.
int PipelineThread::Wait(std::int64_t wait_ns, std::span<epoll_event> events) {
  const auto most = static_cast<int>(events.size());
  const timespec wait{wait_ns / runtime::kSecond_ns, wait_ns % runtime::kSecond_ns};
  const int ready = epoll_pwait2(epoll_.get(), events.data(), most, &wait, nullptr);
  if (ready >= 0 || errno != ENOSYS) return ready;
  const std::int64_t wait_ms = (wait_ns + runtime::kMillisecond_ns - 1) / runtime::kMillisecond_ns;
  return epoll_wait(epoll_.get(), events.data(), most, static_cast<int>(wait_ms));
}

void PipelineThread::Run() {
  std::array<epoll_event, 16> events;
  while (!stop_.load(std::memory_order_relaxed)) {
    turns_.store(turns() + 1, std::memory_order_relaxed);  // written here alone
    if (pipeline_.DoWork() > 0) continue;
    const std::int64_t wait_ns = pipeline_.NextDeadline_ns() - clock_.Now_ns();
    const int ready = Wait(std::clamp<std::int64_t>(wait_ns, 0, runtime::kSecond_ns), events);
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
