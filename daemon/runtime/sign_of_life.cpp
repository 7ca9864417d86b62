#include "daemon/runtime/sign_of_life.h"

#include <poll.h>
#include <pthread.h>

#include <utility>

namespace styled::runtime {

SignOfLife::SignOfLife(const std::string& address, std::function<std::uint64_t()> turns,
                       std::function<void()> wake)
    : notifier_(address),
      turns_(std::move(turns)),
      wake_(std::move(wake)),
      thread_([this] { Run(); }) {}

SignOfLife::~SignOfLife() {
  stop_.Signal();
  thread_.join();
}

void SignOfLife::Run() {
  pthread_setname_np(pthread_self(), "sign of life");
  std::uint64_t seen = 0;
  pollfd stop{stop_.fd(), POLLIN, 0};
  do {
    const std::uint64_t turns = turns_();
    if (turns != seen) notifier_.Alive();
    seen = turns;
    wake_();
  } while (poll(&stop, 1, kLook_ms) <= 0);
}

bool WatchdogAsked(const char* usec, const char* watchdog_pid, int pid) {
  if (usec == nullptr || std::atoll(usec) <= 0) return false;
  return watchdog_pid == nullptr || std::atoll(watchdog_pid) == pid;
}

}  // namespace styled::runtime
