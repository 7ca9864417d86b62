#include "daemon/runtime/realtime.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstring>

namespace styled::runtime {

HotSection::Mark HotSection::enter_ = nullptr;
HotSection::Mark HotSection::exit_ = nullptr;

void HotSection::Find() {
  enter_ = reinterpret_cast<Mark>(dlsym(RTLD_DEFAULT, "styled_realtime_enter"));
  exit_ = reinterpret_cast<Mark>(dlsym(RTLD_DEFAULT, "styled_realtime_exit"));
}

std::vector<std::string> LockMemory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  if (limit.rlim_cur != RLIM_INFINITY && geteuid() != 0) {
    return {
        "memory is not locked: RLIMIT_MEMLOCK is finite (ulimit -l unlimited, or "
        "realtime.lock_memory = false)"};
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    return {std::string("memory is not locked: ") + std::strerror(errno)};
  }
  return {};
}

std::vector<std::string> ApplyScheduling(const Scheduling& scheduling) {
  std::vector<std::string> refused;
  if (scheduling.priority > 0) {
    sched_param parameter{};
    parameter.sched_priority = scheduling.priority;
    const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
    if (error != 0) {
      refused.push_back("SCHED_FIFO priority " + std::to_string(scheduling.priority) + ": " +
                        std::strerror(error));
    }
  }
  if (scheduling.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(scheduling.cpu), &set);
    const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
    if (error != 0) {
      refused.push_back("cpu " + std::to_string(scheduling.cpu) + ": " + std::strerror(error));
    }
  }
  return refused;
}

}  // namespace styled::runtime
