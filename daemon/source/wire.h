#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

// Protobuf's wire format (protobuf.dev/programming-guides/encoding), without its objects, which
// would allocate. No allocation; one thread per object.
namespace styled::source {

// Protobuf's wire types.
enum WireType : std::uint32_t { kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5 };

// A cursor over protobuf's encoding. Every method returns false at the first malformed byte.
class WireReader {
 public:
  explicit WireReader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}
  bool AtEnd() const noexcept { return bytes_.empty(); }
  const std::byte* at() const noexcept { return bytes_.data(); }

  bool Varint(std::uint64_t& value) noexcept {
    value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      if (bytes_.empty()) return false;
      const auto byte = std::to_integer<std::uint64_t>(bytes_.front());
      bytes_ = bytes_.subspan(1);
      value |= (byte & 0x7FU) << shift;
      if (byte < 0x80U) return true;
    }
    return false;
  }

  bool Tag(std::uint32_t& field, std::uint32_t& wire) noexcept {
    std::uint64_t tag = 0;
    if (!Varint(tag) || tag > 0xFFFFFFFFU) return false;
    field = static_cast<std::uint32_t>(tag >> 3U);
    wire = static_cast<std::uint32_t>(tag & 7U);
    return field != 0;
  }

  bool Bytes(std::span<const std::byte>& value) noexcept {
    std::uint64_t length = 0;
    if (!Varint(length) || length > bytes_.size()) return false;
    value = bytes_.first(static_cast<std::size_t>(length));
    bytes_ = bytes_.subspan(static_cast<std::size_t>(length));
    return true;
  }

  template <typename T>
  bool Fixed(T& value) noexcept {
    if (bytes_.size() < sizeof value) return false;
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return true;
  }

  bool Skip(std::uint32_t wire) noexcept {
    std::uint64_t number = 0;
    std::uint32_t word = 0;
    std::span<const std::byte> bytes;
    switch (wire) {
      case kVarint:
        return Varint(number);
      case kFixed64:
        return Fixed(number);
      case kBytes:
        return Bytes(bytes);
      case kFixed32:
        return Fixed(word);
      default:
        return false;  // groups: retired from proto3
    }
  }

 private:
  std::span<const std::byte> bytes_;
};

inline std::size_t VarintSize(std::size_t value) noexcept {
  std::size_t size = 1;
  for (; value >= 0x80U; value >>= 7U) ++size;
  return size;
}

// Writes until an element does not fit, then nothing more.
class WireWriter {
 public:
  explicit WireWriter(std::span<std::byte> to) noexcept : to_(to) {}
  bool fits() const noexcept { return fits_; }
  std::size_t size() const noexcept { return size_; }

  void Varint(std::size_t value) noexcept {
    for (; value >= 0x80U; value >>= 7U) Byte(static_cast<std::byte>(value | 0x80U));
    Byte(static_cast<std::byte>(value));
  }
  void Bytes(std::span<const std::byte> bytes) noexcept {
    fits_ = fits_ && bytes.size() <= to_.size() - size_;
    if (!fits_ || bytes.empty()) return;
    std::memcpy(&to_[size_], bytes.data(), bytes.size());
    size_ += bytes.size();
  }

 private:
  void Byte(std::byte byte) noexcept { Bytes({&byte, 1}); }

  std::span<std::byte> to_;
  std::size_t size_ = 0;
  bool fits_ = true;
};

}  // namespace styled::source
