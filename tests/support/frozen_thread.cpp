#include "tests/support/frozen_thread.h"

#include <sys/ptrace.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace styled::support {
namespace {

pid_t Find(pid_t pid, const std::string& wanted) {
  const std::filesystem::path tasks = "/proc/" + std::to_string(pid) + "/task";
  std::error_code error;
  for (const auto& task : std::filesystem::directory_iterator(tasks, error)) {
    std::string name;
    std::getline(std::ifstream(task.path() / "comm"), name);
    if (name == wanted) return std::stoi(task.path().filename());
  }
  return 0;
}

}  // namespace

FrozenThread::FrozenThread(pid_t pid, const std::string& name) : thread_(Find(pid, name)) {
  if (thread_ == 0) {
    error_ = "no thread " + name;
    return;
  }
  int status = 0;
  frozen_ = ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) == 0 &&
            ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr) == 0 &&
            waitpid(thread_, &status, __WALL) == thread_ && WIFSTOPPED(status);
  if (!frozen_) error_ = std::string("ptrace: ") + std::strerror(errno);
}

FrozenThread::~FrozenThread() {
  if (frozen_) ptrace(PTRACE_DETACH, thread_, nullptr, nullptr);
}

void FrozenThread::AwaitDeath() {
  int status = 0;
  while (frozen_ && waitpid(thread_, &status, __WALL) == thread_) {
    if (WIFEXITED(status) || WIFSIGNALED(status)) frozen_ = false;
  }
}

}  // namespace styled::support
