#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace styled {

// The FNV-1a hash, 64 bit. It detects accidental differences; it is not cryptographic. Files,
// frames and weights store its values, so the result is the same on every machine (except Bytes,
// which hashes the memory as it is). Pure; any thread. Pinned by tests/unit/base/hash_test.cpp.
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
  // `size` bytes in memory order; a number in them hashes by the machine's byte order.
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
