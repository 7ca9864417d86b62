#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <utility>

namespace styled::runtime {

// Bounded ring between two threads, one producer and one consumer. Neither side ever waits. The
// ring allocates nothing; values are moved in and out. Capacity is a power of two.
template <typename T, std::size_t Capacity>
class Ring {
  static_assert(Capacity > 0 && (Capacity & (Capacity - 1)) == 0);

 public:
  // Returns false and leaves `value` untouched when the ring is full. Producer thread only.
  bool Push(T&& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == Capacity) return false;
    slots_[head % Capacity] = std::move(value);
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  // Returns false and leaves `value` untouched when the ring is empty. Consumer thread only.
  bool Pop(T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return false;
    value = std::move(slots_[tail % Capacity]);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, Capacity> slots_{};
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace styled::runtime
