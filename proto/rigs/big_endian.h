#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

// For codecs only: reading and writing the big-endian bytes of a rig's protocol (little-endian
// ones: cursor.h). Nothing here allocates, blocks or throws. Pinned by the codecs' tests,
// tests/unit/mvn, slimevr and livelinkface.
namespace styled::rigs {

// Reads from the front. Past the end it returns zeros and ok() becomes false.
class BigEndianReader {
 public:
  BigEndianReader() = default;
  explicit BigEndianReader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

  bool ok() const noexcept { return ok_; }
  std::size_t left() const noexcept { return bytes_.size(); }

  std::span<const std::byte> Bytes(std::size_t size) noexcept {
    if (size > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
      return {};
    }
    const auto read = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return read;
  }
  template <typename T>
  T Number() noexcept {
    std::uint64_t value = 0;
    for (const std::byte b : Bytes(sizeof(T))) value = value << 8U | std::to_integer<unsigned>(b);
    return static_cast<T>(value);
  }
  std::uint8_t U8() noexcept { return Number<std::uint8_t>(); }
  std::uint32_t U32() noexcept { return Number<std::uint32_t>(); }
  float Float() noexcept { return std::bit_cast<float>(U32()); }
  std::string_view Text(std::size_t size) noexcept {
    const auto bytes = Bytes(size);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

 private:
  std::span<const std::byte> bytes_;
  bool ok_ = true;
};

// Writes to the front. If something does not fit, size() is 0.
class BigEndianWriter {
 public:
  explicit BigEndianWriter(std::span<std::byte> out) noexcept : out_(out) {}

  std::size_t size() const noexcept { return ok_ ? at_ : 0; }
  template <typename T>
  void Number(T value) noexcept {
    if (at_ + sizeof(T) > out_.size()) ok_ = false;
    if (!ok_) return;
    for (std::size_t i = sizeof(T); i-- > 0;) {
      out_[at_++] = static_cast<std::byte>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xFFU);
    }
  }
  void U8(std::uint32_t value) noexcept { Number(static_cast<std::uint8_t>(value)); }
  void U32(std::uint32_t value) noexcept { Number(value); }
  void Float(float value) noexcept { U32(std::bit_cast<std::uint32_t>(value)); }
  void Floats(std::span<const float> values) noexcept {
    for (const float value : values) Float(value);
  }
  void Text(std::string_view text) noexcept {
    for (const char c : text) U8(static_cast<std::uint8_t>(c));
  }

 private:
  std::span<std::byte> out_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace styled::rigs
