#include "daemon/runtime/helpers.h"

#include <chrono>

namespace styled::runtime {
namespace {

// Tells the processor that the thread polls, so that the other thread of the core gets its share.
void Pause() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Polls of the owner for the parts that helpers have taken, before it sleeps: some 20 us, a frame's
// time. It would sleep at once if a helper were slower than that for want of a processor.
constexpr int kOwnersPolls = 500;

}  // namespace

std::uint64_t Helpers::Packed(Left left) noexcept {
  return std::uint64_t{left.run} << 32U | std::uint64_t{left.parts} << 16U | left.next;
}

Helpers::Left Helpers::Unpacked(std::uint64_t word) noexcept {
  return {static_cast<std::uint32_t>(word >> 32U), static_cast<std::uint16_t>(word >> 16U),
          static_cast<std::uint16_t>(word)};
}

Helpers::Helpers(int count, const std::function<void(int)>& begin) {
  threads_.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    threads_.emplace_back([this, begin, i] {
      begin(i);
      Help();
    });
  }
}

Helpers::~Helpers() {
  stop_.store(true, std::memory_order_relaxed);
  called_.fetch_add(1, std::memory_order_release);
  called_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

bool Helpers::AnyLeft() const noexcept {
  const Left left = Unpacked(left_.load(std::memory_order_acquire));
  return left.next < left.parts;
}

bool Helpers::DoPart() noexcept {
  std::uint64_t word = left_.load(std::memory_order_acquire);
  for (;;) {
    Left left = Unpacked(word);
    if (left.next >= left.parts) return false;
    const int part = left.next++;
    if (!left_.compare_exchange_weak(word, Packed(left), std::memory_order_acq_rel,
                                     std::memory_order_acquire)) {
      continue;
    }
    // The run cannot end before this part does, so call_ and work_ are its own.
    call_(work_, part);
    done_.fetch_add(1, std::memory_order_release);
    done_.notify_one();
    return true;
  }
}

void Helpers::RunShared(int parts, Call call, const void* work) noexcept {
  call_ = call;
  work_ = work;
  done_.store(0, std::memory_order_relaxed);
  const Left last = Unpacked(left_.load(std::memory_order_relaxed));
  left_.store(Packed({last.run + 1, static_cast<std::uint16_t>(parts), 0}),
              std::memory_order_release);
  called_.fetch_add(1, std::memory_order_release);
  called_.notify_one();
  while (DoPart()) continue;
  const auto all = static_cast<std::uint32_t>(parts);
  for (int polls = 0;; ++polls) {
    const std::uint32_t done = done_.load(std::memory_order_acquire);
    if (done == all) return;
    if (polls < kOwnersPolls) {
      Pause();
    } else {
      done_.wait(done, std::memory_order_acquire);
    }
  }
}

void Helpers::Help() {
  using Clock = std::chrono::steady_clock;
  while (!stop_.load(std::memory_order_relaxed)) {
    const std::uint32_t called = called_.load(std::memory_order_acquire);
    bool helped = false;
    while (AnyLeft()) {
      // The owner wakes one helper, and each wakes the next, so that the owner makes one system
      // call.
      if (!helped) called_.notify_one();
      helped = true;
      (void)DoPart();
    }
    if (helped) {
      const auto until = Clock::now() + std::chrono::microseconds(kPoll_us);
      while (called_.load(std::memory_order_relaxed) == called && Clock::now() < until) Pause();
    }
    called_.wait(called, std::memory_order_acquire);
  }
}

}  // namespace styled::runtime
