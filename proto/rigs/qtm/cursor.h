#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "proto/rigs/qtm/packet.h"

// For the codec only: reading and writing little-endian bytes.
static_assert(std::endian::native == std::endian::little);

namespace styled::qtm {

// Reads from the front. Keeps the first error; after it all values are zero or empty.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

  bool ok() const noexcept { return result_ == DecodeResult::kOk; }
  DecodeResult result() const noexcept { return result_; }
  std::size_t left() const noexcept { return bytes_.size(); }

  void Fail(DecodeResult why) noexcept {
    if (ok()) result_ = why;
    bytes_ = {};
  }
  std::span<const std::byte> Take(std::size_t size) noexcept {
    if (size > bytes_.size()) {
      Fail(DecodeResult::kTruncated);
      return {};
    }
    const auto taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }
  // A number or an array of floats.
  template <typename T>
  T Get() noexcept {
    T value{};
    const auto taken = Take(sizeof(T));
    if (!taken.empty()) std::memcpy(&value, taken.data(), sizeof(T));
    return value;
  }
  // The number of elements of at least `smallest` bytes that follow.
  std::size_t GetCount(std::size_t smallest) noexcept {
    const auto count = Get<std::uint32_t>();
    if (count > left() / smallest) {
      Fail(DecodeResult::kBadCount);
      return 0;
    }
    return count;
  }

 private:
  std::span<const std::byte> bytes_;
  DecodeResult result_ = DecodeResult::kOk;
};

// Writes a packet from the front of `out`. After the first value that does not fit nothing more is
// written.
class Writer {
 public:
  Writer(PacketType type, std::span<std::byte> out) noexcept : out_(out) {
    Put<std::uint32_t>(0);
    Put(type);
  }
  void PutBytes(std::span<const std::byte> bytes) noexcept {
    full_ = full_ || bytes.size() > out_.size() - size_;
    if (full_ || bytes.empty()) return;
    std::memcpy(&out_[size_], bytes.data(), bytes.size());
    size_ += bytes.size();
  }
  template <typename T>
  void Put(const T& value) noexcept {
    PutBytes(std::as_bytes(std::span(&value, 1)));
  }
  // A component's header; End writes its size.
  std::size_t Begin(std::uint32_t type) noexcept {
    const std::size_t at = size_;
    Put<std::uint32_t>(0);
    Put(type);
    return at;
  }
  void End(std::size_t at) noexcept { SetSize(at, size_ - at); }
  // Writes the packet's size and returns it; 0 if it did not fit.
  std::size_t Finish() noexcept {
    SetSize(0, size_);
    return full_ ? 0 : size_;
  }

 private:
  void SetSize(std::size_t at, std::size_t size) noexcept {
    if (full_) return;
    const auto value = static_cast<std::uint32_t>(size);
    std::memcpy(&out_[at], &value, sizeof value);
  }

  std::span<std::byte> out_;
  std::size_t size_ = 0;
  bool full_ = false;
};

}  // namespace styled::qtm
