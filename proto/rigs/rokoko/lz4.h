#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "model/base/realtime.h"

// LZ4's frame format through liblz4, with contexts that are created once. Pinned against the output
// of the `lz4` command by tests/unit/rokoko/lz4_test.cpp.
namespace styled::rokoko {

// Whether the bytes begin as an LZ4 frame: 04 22 4D 18.
bool IsLz4Frame(std::span<const std::byte> bytes) noexcept;

// The constructor allocates all memory that any frame can require. One thread.
class Lz4Unpacker {
 public:
  Lz4Unpacker();
  ~Lz4Unpacker();
  Lz4Unpacker(const Lz4Unpacker&) = delete;
  Lz4Unpacker& operator=(const Lz4Unpacker&) = delete;

  enum class [[nodiscard]] Result : unsigned char {
    kOk,
    kBad,     // not a frame, a damaged or truncated one, or bytes after it
    kTooLong  // the content exceeds `out`
  };
  // Unpacks `packed`, which must be exactly one frame. Writes `size` on kOk only.
  STYLED_REALTIME Result Unpack(std::span<const std::byte> packed, std::span<std::byte> out,
                                std::size_t& size) noexcept;

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

// For simulators. One thread; the first frame may allocate.
class Lz4Packer {
 public:
  Lz4Packer();
  ~Lz4Packer();
  Lz4Packer(const Lz4Packer&) = delete;
  Lz4Packer& operator=(const Lz4Packer&) = delete;

  // Packs `text` as one frame with a checksum and returns its size, or 0 if `out` is too small.
  // `out` needs room for incompressible text: its size and a few dozen bytes more.
  std::size_t Pack(std::span<const std::byte> text, std::span<std::byte> out) noexcept;

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace styled::rokoko
