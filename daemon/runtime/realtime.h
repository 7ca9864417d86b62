#pragma once

#include <string>
#include <vector>

namespace styled::runtime {

// Marks the section of the pipeline thread that must not allocate, lock, log or throw: from the
// return of receive to the entry of zmq_send. In production each mark only tests a null pointer.
// tests/realtime preloads a library that defines styled_realtime_enter() and styled_realtime_exit()
// and counts every call of an allocating or locking function between the two.
class HotSection {
 public:
  HotSection() noexcept { Enter(); }
  enum Outside { kOutside };
  explicit HotSection(Outside) noexcept {}  // not entered yet
  ~HotSection() { Leave(); }
  HotSection(const HotSection&) = delete;
  HotSection& operator=(const HotSection&) = delete;
  // Ends the section before the object is destroyed: before zmq_send, or before allocating work
  // that the promise excludes (a new body).
  void Leave() noexcept {
    if (inside_ && exit_ != nullptr) exit_();
    inside_ = false;
  }
  void Enter() noexcept {
    if (!inside_ && enter_ != nullptr) enter_();
    inside_ = true;
  }
  // Looks for the preloaded functions. Call once, before any thread starts.
  static void Find();

 private:
  using Mark = void (*)();
  static Mark enter_, exit_;
  bool inside_ = false;
};

// The pipeline thread's scheduling; all of it is optional.
struct Scheduling {
  bool lock_memory = true;
  int priority = 0;  // SCHED_FIFO priority 1..99; 0 = normal scheduling
  int cpu = -1;      // -1 = any
};

// Locks the process' memory, present and future. Does nothing where RLIMIT_MEMLOCK is finite and
// the process is not root: a process locked in part would fail to allocate later. Call on the main
// thread. Returns a message for each failure; empty on success.
std::vector<std::string> LockMemory();

// Applies priority and cpu to the calling thread. Returns a message for each setting that was
// refused.
std::vector<std::string> ApplyScheduling(const Scheduling& scheduling);

}  // namespace styled::runtime
