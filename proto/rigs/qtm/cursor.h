#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/rigs/cursor.h"
#include "proto/rigs/qtm/packet.h"

// For the codec only: QTM RT's additions to the cursors that codecs share.
namespace styled::qtm {

class Reader : public rigs::ByteReader<DecodeResult> {
 public:
  using ByteReader::ByteReader;

  // The number of elements of at least `smallest` bytes that follow.
  std::size_t GetCount(std::size_t smallest) noexcept {
    const auto count = Get<std::uint32_t>();
    if (count > left() / smallest) {
      Fail(DecodeResult::kBadCount);
      return 0;
    }
    return count;
  }
};

// Writes a packet.
class Writer : public rigs::ByteWriter {
 public:
  Writer(PacketType type, std::span<std::byte> out) noexcept : ByteWriter(out) {
    Put<std::uint32_t>(0);
    Put(type);
  }
  // A component's header; End writes its size.
  std::size_t Begin(std::uint32_t type) noexcept {
    const std::size_t at = At();
    Put<std::uint32_t>(0);
    Put(type);
    return at;
  }
  void End(std::size_t at) noexcept { SetAt(at, static_cast<std::uint32_t>(At() - at)); }
  // Writes the packet's size and returns it; 0 if it did not fit.
  std::size_t Finish() noexcept {
    End(0);
    return Written();
  }
};

}  // namespace styled::qtm
