#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "model/base/realtime.h"

// LZ4's frame format through liblz4, with contexts that are made once. Pinned against the `lz4`
// command's bytes by tests/unit/rokoko/lz4_test.cpp.
namespace styled::rokoko {

// Whether the bytes begin as an LZ4 frame: 04 22 4D 18.
bool IsLz4Frame(std::span<const std::byte> bytes) noexcept;

// The constructor allocates all memory that any frame can need. One thread.
class Lz4Unpacker {
 public:
  Lz4Unpacker();
  ~Lz4Unpacker();
  Lz4Unpacker(const Lz4Unpacker&) = delete;
  Lz4Unpacker& operator=(const Lz4Unpacker&) = delete;

  enum class [[nodiscard]] Result : unsigned char {
    kOk,
    kBad,     // no frame, a damaged or cut one, or bytes behind it
    kTooLong  // it holds more than `out`
  };
  // Unpacks the one frame that `packed` is; `size` is written on kOk alone.
  STYLED_REALTIME Result Unpack(std::span<const std::byte> packed, std::span<std::byte> out,
                                std::size_t& size) noexcept;

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

// For senders. One thread; the first frame may allocate.
class Lz4Packer {
 public:
  Lz4Packer();
  ~Lz4Packer();
  Lz4Packer(const Lz4Packer&) = delete;
  Lz4Packer& operator=(const Lz4Packer&) = delete;

  // Packs `text` as one frame with a checksum; its size, or 0 where `out` is too small. `out` needs
  // room for text that cannot be packed: its size and a few dozen bytes more.
  std::size_t Pack(std::span<const std::byte> text, std::span<std::byte> out) noexcept;

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace styled::rokoko
