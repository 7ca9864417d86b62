#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

namespace styled::runtime {

// Threads that help one thread, the owner, with work that consists of independent parts. The owner
// and the helpers that are free take one part after the other. A helper that the system does not
// schedule in time therefore delays nothing: the owner does the parts that no helper took.
//
// A helper polls for kPoll_us after its last part, so that the next work of the same cycle finds it
// awake, and then sleeps. Run neither allocates nor locks; it makes a system call if a helper
// sleeps. Pinned by tests/unit/daemon/runtime/helpers_test.cpp.
class Helpers {
 public:
  static constexpr int kMost = 31;
  // Long enough to bridge the time between two groups of frames of one cycle: receiving, sending.
  static constexpr int kPoll_us = 50;

  // `count` threads, 0 .. kMost. Each calls `begin` with its number first, for its name and
  // scheduling.
  explicit Helpers(
      int count, const std::function<void(int)>& begin = [](int) {});
  ~Helpers();
  Helpers(const Helpers&) = delete;
  Helpers& operator=(const Helpers&) = delete;

  int count() const { return static_cast<int>(threads_.size()); }

  // Calls work(part) once for each part 0 .. parts - 1 and returns when all calls have returned.
  // The owner's thread only. `work` must not throw.
  template <typename Work>
  void Run(int parts, const Work& work) noexcept {
    if (parts <= 1 || threads_.empty()) {
      for (int part = 0; part < parts; ++part) work(part);
      return;
    }
    RunShared(
        parts,
        [](const void* the_work, int part) noexcept {
          (*static_cast<const Work*>(the_work))(part);
        },
        &work);
  }

 private:
  using Call = void (*)(const void* work, int part) noexcept;

  // The parts left to take of the current run. One word, so that a helper that is late cannot take
  // a part of one run for a part of the next.
  struct Left {
    std::uint32_t run = 0;
    std::uint16_t parts = 0, next = 0;
  };
  static std::uint64_t Packed(Left left) noexcept;
  static Left Unpacked(std::uint64_t word) noexcept;

  void RunShared(int parts, Call call, const void* work) noexcept;
  bool AnyLeft() const noexcept;
  // Takes and does one part of the current run; false if none is left.
  bool DoPart() noexcept;
  void Help();

  std::vector<std::thread> threads_;
  // Written by the owner before `left_` offers the parts, and not while a part is being done.
  Call call_ = nullptr;
  const void* work_ = nullptr;
  std::atomic<std::uint64_t> left_{0};
  std::atomic<std::uint32_t> done_{0};    // parts of the current run
  std::atomic<std::uint32_t> called_{0};  // changes when sleepers must wake
  std::atomic<bool> stop_{false};
};

}  // namespace styled::runtime
