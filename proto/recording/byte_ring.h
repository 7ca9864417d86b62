#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <vector>

#include "model/base/realtime.h"

namespace styled::recording {

// Bounded ring of messages of any size between two threads, one producer and one consumer. Neither
// waits; pushing neither allocates nor locks. A message is pushed completely or not at all. Pinned
// by tests/unit/recording/byte_ring_test.cpp.
class ByteRing {
 public:
  // `capacity` in bytes, a power of two. The constructor touches the memory, so that pushing causes
  // no page fault.
  explicit ByteRing(std::size_t capacity) : bytes_(capacity) {
    assert(std::has_single_bit(capacity) && capacity >= 64);
  }

  // Pushes the parts, concatenated, as one message. Returns false and pushes nothing if there is no
  // room. Producer thread only.
  STYLED_REALTIME bool Push(std::initializer_list<std::span<const std::byte>> parts) noexcept {
    std::size_t size = 0;
    for (const auto& part : parts) size += part.size();
    std::size_t head = head_.load(std::memory_order_relaxed);
    const std::size_t used = head - tail_.load(std::memory_order_acquire);
    if (size > bytes_.size() || kPrefix + size > bytes_.size() - used) return false;
    std::array<std::byte, kPrefix> prefix;
    const auto size32 = static_cast<std::uint32_t>(size);
    std::memcpy(prefix.data(), &size32, kPrefix);
    head = Put(head, prefix);
    for (const auto& part : parts) head = Put(head, part);
    head_.store(head, std::memory_order_release);
    return true;
  }

  // Pops the oldest message into `out`; returns false if there is none. Consumer thread only.
  bool Pop(std::vector<std::byte>& out) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return false;
    std::array<std::byte, kPrefix> prefix;
    Get(tail, prefix);
    std::uint32_t size = 0;
    std::memcpy(&size, prefix.data(), kPrefix);
    out.resize(size);
    Get(tail + kPrefix, out);
    tail_.store(tail + kPrefix + size, std::memory_order_release);
    return true;
  }

 private:
  static constexpr std::size_t kPrefix = sizeof(std::uint32_t);

  STYLED_REALTIME std::size_t Put(std::size_t at, std::span<const std::byte> part) noexcept {
    if (part.empty()) return at;
    const std::size_t index = at & (bytes_.size() - 1);
    const std::size_t first = std::min(part.size(), bytes_.size() - index);
    std::memcpy(bytes_.data() + index, part.data(), first);
    if (first < part.size()) std::memcpy(bytes_.data(), part.data() + first, part.size() - first);
    return at + part.size();
  }
  void Get(std::size_t at, std::span<std::byte> part) const noexcept {
    if (part.empty()) return;
    const std::size_t index = at & (bytes_.size() - 1);
    const std::size_t first = std::min(part.size(), bytes_.size() - index);
    std::memcpy(part.data(), bytes_.data() + index, first);
    if (first < part.size()) std::memcpy(part.data() + first, bytes_.data(), part.size() - first);
  }

  std::vector<std::byte> bytes_;
  alignas(64) std::atomic<std::size_t> head_{0};  // both count bytes since the beginning
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace styled::recording
