#include "daemon/pipeline/pipeline_thread.h"

#include <sys/epoll.h>
#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace styled::pipeline {

PipelineThread::PipelineThread(Worker& worker, std::span<const int> fds, runtime::Wakeup& wake,
                               const runtime::Clock& clock, Wait wait)
    : worker_(worker),
      wake_(wake),
      clock_(clock),
      mode_(wait),
      epoll_(epoll_create1(EPOLL_CLOEXEC)) {
  for (const int fd : fds) Watch(fd);
  Watch(wake.fd());
}

void PipelineThread::Watch(int fd) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = fd;
  epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event);
}

// Waits with nanosecond resolution if the kernel supports it (5.11), so that a delayed frame does
// not leave up to a millisecond late.
int PipelineThread::Sleep(std::int64_t wait_ns, std::span<epoll_event> events) {
  const auto most = static_cast<int>(events.size());
  const timespec wait{wait_ns / runtime::kSecond_ns, wait_ns % runtime::kSecond_ns};
  const int ready = epoll_pwait2(epoll_.get(), events.data(), most, &wait, nullptr);
  if (ready >= 0 || errno != ENOSYS) return ready;
  const std::int64_t wait_ms = (wait_ns + runtime::kMillisecond_ns - 1) / runtime::kMillisecond_ns;
  return epoll_wait(epoll_.get(), events.data(), most, static_cast<int>(wait_ms));
}

bool PipelineThread::StaysAwake() const {
  return mode_ == Wait::kBusy || (mode_ == Wait::kHybrid && worker_.Expects(clock_.Now_ns()));
}

void PipelineThread::Run() {
  prctl(PR_SET_TIMERSLACK, 1UL);  // ns; 50 us by default
  std::array<epoll_event, 16> events;
  while (!stop_.load(std::memory_order_relaxed)) {
    turns_.store(turns() + 1, std::memory_order_relaxed);  // only this thread writes it
    if (worker_.DoWork() > 0 || StaysAwake()) continue;
    const std::int64_t wait_ns = worker_.NextDeadline_ns() - clock_.Now_ns();
    const int ready = Sleep(std::clamp<std::int64_t>(wait_ns, 0, runtime::kSecond_ns), events);
    for (int i = 0; i < ready; ++i) {
      if (events[static_cast<std::size_t>(i)].data.fd == wake_.fd()) wake_.Clear();
    }
  }
}

void PipelineThread::Stop() {
  stop_.store(true, std::memory_order_relaxed);
  wake_.Signal();
}

}  // namespace styled::pipeline
