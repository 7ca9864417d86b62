#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

// Offsets in bytes of the fields of a datagram's header (WIRE.md), and little-endian access to
// them. For the codec, and for simulators that damage datagrams on purpose.
namespace styled::native::header {

inline constexpr std::string_view kMagicText = "STYD";
inline constexpr std::uint8_t kVersionNumber = 1;

inline constexpr std::size_t kMagic = 0;
inline constexpr std::size_t kVersion = 4;
inline constexpr std::size_t kKind = 5;
inline constexpr std::size_t kReserved = 6;
inline constexpr std::size_t kLength = 8;
inline constexpr std::size_t kCrc = 12;
inline constexpr std::size_t kCrcSize = 4;
inline constexpr std::size_t kSession = 16;
inline constexpr std::size_t kSequence = 24;

// `bytes` must extend past the field. Compilers turn the loop into one load or store.
template <typename T>
T Read(std::span<const std::byte> bytes, std::size_t offset) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= std::to_integer<std::uint64_t>(bytes[offset + i]) << (8 * i);
  }
  return static_cast<T>(value);
}

template <typename T>
void Write(std::span<std::byte> bytes, std::size_t offset, T value) noexcept {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[offset + i] =
        static_cast<std::byte>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xFFU);
  }
}

}  // namespace styled::native::header
