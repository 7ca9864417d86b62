#pragma once

#include <array>
#include <bit>
#include <bitset>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "model/base/realtime.h"

namespace styled {

// The state of live objects as bytes: little-endian, in the order of the calls, without padding or
// names. A class has one member function, Carry(Checkpoint&), which passes every value that its
// future depends on. The same function counts the bytes, writes them and reads them, so that the
// three cannot disagree. An object that has read a checkpoint continues exactly like the one that
// wrote it, bit for bit, if both were constructed alike (network, skeleton, options). Sizes are
// fixed by the construction: they are checked, not changed.
//
// Reading accepts any bytes. Data that is too short, of another size or out of bounds makes ok()
// false, and nothing more is read. The object is then in an unspecified state and must be reset or
// dropped. Numbers of which any value is harmless may come out as NaN.
//
// No allocation; one thread at a time. Pinned by tests/unit/base/checkpoint_test.cpp.
class Checkpoint {
 public:
  Checkpoint() = default;  // counts only
  static Checkpoint Into(std::span<std::byte> to) noexcept {
    Checkpoint checkpoint;
    checkpoint.to_ = to.data();
    checkpoint.room_ = to.size();
    return checkpoint;
  }
  static Checkpoint From(std::span<const std::byte> from) noexcept {
    Checkpoint checkpoint;
    checkpoint.from_ = from.data();
    checkpoint.room_ = from.size();
    return checkpoint;
  }

  bool reads() const { return from_ != nullptr; }
  bool ok() const { return ok_; }
  std::size_t size() const { return size_; }  // bytes so far
  // Whether all of the given bytes have been read.
  bool complete() const { return ok_ && size_ == room_; }

  // Numbers, bool, Eigen's matrices and quaternions, arrays, vectors, bitsets, and objects with a
  // Carry of their own.
  template <typename... Values>
  STYLED_REALTIME void operator()(Values&... values) noexcept {
    (One(values), ...);
  }
  // A number that is used as an index or a count: `least` .. `most`.
  template <std::integral Number>
  STYLED_REALTIME void Within(Number& value, std::type_identity_t<Number> least,
                              std::type_identity_t<Number> most) noexcept {
    Number read = value;
    Bytes(&read, sizeof read);
    if (read < least || read > most) return Refuse();
    if (ok_) value = read;
  }
  // A time in nanoseconds: differences of two never overflow.
  STYLED_REALTIME void Time(std::int64_t& value_ns) noexcept {
    constexpr std::int64_t kMost_ns = std::int64_t{1} << 61;  // 73 years
    Within(value_ns, -kMost_ns, kMost_ns);
  }
  // A value that must be the same in writer and reader.
  STYLED_REALTIME void Same(std::uint64_t value) noexcept {
    std::uint64_t theirs = value;
    Bytes(&theirs, sizeof theirs);
    if (theirs != value) Refuse();
  }
  // Ends reading: a value violates one of its own rules.
  STYLED_REALTIME void Refuse() noexcept { ok_ = false; }

 private:
  static_assert(std::endian::native == std::endian::little);

  STYLED_REALTIME void Bytes(void* value, std::size_t count) noexcept {
    if (!ok_) return;
    if (to_ != nullptr || from_ != nullptr) {
      if (count > room_ - size_) return Refuse();
      if (count == 0) return;
      if (to_ != nullptr) {
        std::memcpy(to_ + size_, value, count);
      } else {
        std::memcpy(value, from_ + size_, count);
      }
    }
    size_ += count;
  }

  template <typename Value>
  STYLED_REALTIME void One(Value& value) noexcept {
    if constexpr (std::is_same_v<Value, bool>) {
      std::uint8_t byte = value ? 1 : 0;
      Within(byte, 0, 1);
      value = byte != 0;
    } else if constexpr (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::byte>) {
      Bytes(&value, sizeof value);
    } else if constexpr (requires { value.Carry(*this); }) {
      value.Carry(*this);
    } else if constexpr (requires { value.coeffs().data(); }) {  // a quaternion
      Bytes(value.coeffs().data(), sizeof(float) * 4);
      static_assert(std::is_same_v<typename Value::Scalar, float>);
    } else if constexpr (requires { typename Value::Scalar; }) {  // a matrix
      Bytes(value.data(), sizeof(typename Value::Scalar) * static_cast<std::size_t>(value.size()));
    } else {
      Many(value);
    }
  }
  template <typename Value, std::size_t kSize>
  STYLED_REALTIME void Many(std::array<Value, kSize>& values) noexcept {
    Each<Value>(values);
  }
  template <typename Value>
  STYLED_REALTIME void Many(std::vector<Value>& values) noexcept {
    Same(values.size());
    Each<Value>(values);
  }
  template <typename Value>
  STYLED_REALTIME void Many(std::span<Value>& values) noexcept {
    Same(values.size());
    Each<Value>(values);
  }
  template <std::size_t kBits>
  STYLED_REALTIME void Many(std::bitset<kBits>& bits) noexcept {
    for (std::size_t begin = 0; begin < kBits; begin += 8) {
      std::uint8_t byte = 0;
      for (std::size_t i = 0; i < 8 && begin + i < kBits; ++i) {
        byte = static_cast<std::uint8_t>(byte | (bits.test(begin + i) ? 1U << i : 0U));
      }
      Bytes(&byte, 1);
      for (std::size_t i = 0; i < 8 && begin + i < kBits; ++i) {
        bits.set(begin + i, (byte >> i & 1U) != 0);
      }
    }
  }
  template <typename Value>
  STYLED_REALTIME void Each(std::span<Value> values) noexcept {
    if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      Bytes(values.data(), values.size_bytes());
    } else {
      for (Value& value : values) One(value);
    }
  }

  std::byte* to_ = nullptr;
  const std::byte* from_ = nullptr;
  std::size_t room_ = 0, size_ = 0;
  bool ok_ = true;
};

}  // namespace styled
