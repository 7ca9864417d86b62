#pragma once

#include <string>
#include <vector>

namespace styled::runtime {

// Marks the stretch of the pipeline thread that must not allocate, lock, log or throw: from the
// return of receive to the entry of zmq_send. In production both calls are a test of a null
// pointer; tests/realtime preloads a library that defines styled_realtime_enter() and
// styled_realtime_exit() and counts, between them, every call of an allocation or locking entry
// point.
class HotSection {
 public:
  HotSection() noexcept { Enter(); }
  enum Outside { kOutside };
  explicit HotSection(Outside) noexcept {}  // not entered yet
  ~HotSection() { Leave(); }
  HotSection(const HotSection&) = delete;
  HotSection& operator=(const HotSection&) = delete;
  // Ends the section before the object does: on the way to zmq_send, or to allocating work that is
  // not part of the promise (a new body).
  void Leave() noexcept {
    if (inside_ && exit_ != nullptr) exit_();
    inside_ = false;
  }
  void Enter() noexcept {
    if (!inside_ && enter_ != nullptr) enter_();
    inside_ = true;
  }
  // Looks for the preloaded functions; once, before any thread starts.
  static void Find();

 private:
  using Mark = void (*)();
  static Mark enter_, exit_;
  bool inside_ = false;
};

// What the pipeline thread asks of the kernel; all of it optional.
struct Scheduling {
  bool lock_memory = true;
  int priority = 0;  // SCHED_FIFO priority 1..99; 0 = normal scheduling
  int cpu = -1;      // -1 = any
};

// Locks the process' memory, present and future, where the limit allows all of it: a partly locked
// process would fail to allocate later. Call on the main thread. Returns what could not be had.
std::vector<std::string> LockMemory();

// Applies priority and cpu to the calling thread. Returns what could not be had.
std::vector<std::string> ApplyScheduling(const Scheduling& scheduling);

}  // namespace styled::runtime
