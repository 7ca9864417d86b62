#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace styled {

// FNV-1a, 64 bit: tells things apart, resists nobody. Files, frames and weights carry its values,
// so they are the same on every machine. Pure; any thread. Pinned by tests/unit/base/hash_test.cpp.
class Fnv1a {
 public:
  constexpr void Byte(unsigned char byte) noexcept { value_ = (value_ ^ byte) * 1099511628211ULL; }
  constexpr void Text(std::string_view text) noexcept {
    for (const char c : text) Byte(static_cast<unsigned char>(c));
  }
  // The low 32 bits, least significant byte first.
  constexpr void Number(std::int64_t value) noexcept {
    for (int shift = 0; shift < 32; shift += 8) Byte(static_cast<unsigned char>(value >> shift));
  }
  // `size` bytes as they lie in memory.
  void Bytes(const void* data, std::size_t size) noexcept {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) Byte(bytes[i]);
  }
  constexpr std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ULL;
};

constexpr std::uint64_t HashOf(std::string_view text) noexcept {
  Fnv1a hash;
  hash.Text(text);
  return hash.value();
}

}  // namespace styled
