#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "proto/rigs/cursor.h"
#include "proto/rigs/natnet/packet.h"

// For the codec only: NatNet's additions to the cursors that codecs share.
namespace styled::natnet {

// From this version on, sections and data sets state their sizes, and a frame has assets and PTP
// time.
inline constexpr Version kSized{4, 1};
// Whether every element of the bitstream is known. Of a later one only the parts that its sizes
// delimit are read.
constexpr bool IsKnown(Version version) noexcept { return version < Version{4, 3}; }

class Reader : public rigs::ByteReader<DecodeResult> {
 public:
  using ByteReader::ByteReader;

  void Skip(std::size_t size) noexcept { Consume(size); }

  // Reads a text and its terminating NUL.
  std::string_view GetText() noexcept {
    const auto end = std::find(bytes_.begin(), bytes_.end(), std::byte{0});
    if (end == bytes_.end()) {
      Fail(DecodeResult::kTruncated);
      return {};
    }
    const auto taken = Consume(static_cast<std::size_t>(end - bytes_.begin()) + 1);
    return {reinterpret_cast<const char*>(taken.data()), taken.size() - 1};
  }

  // Reads the number of elements of at least `smallest` bytes that follow.
  std::size_t GetCount(std::size_t smallest) noexcept {
    const auto count = Get<std::int32_t>();
    if (count < 0 || static_cast<std::size_t>(count) > left() / smallest) {
      Fail(DecodeResult::kBadCount);
      return 0;
    }
    return static_cast<std::size_t>(count);
  }

  // Sub splits off a part with its own end. Join adopts the part's error after it was read;
  // `exact`: it must have been read to its end.
  Reader Sub(std::size_t size) noexcept { return Reader(Consume(size)); }
  void Join(const Reader& part, bool exact) noexcept {
    if (!part.ok()) return Fail(part.result());
    if (exact && part.left() > 0) Fail(DecodeResult::kSizeMismatch);
  }
};

// Writes a packet.
class Writer : public rigs::ByteWriter {
 public:
  explicit Writer(std::span<std::byte> out) noexcept
      : ByteWriter(out.first(std::min(out.size(), kMaxPacketSize))) {
    Put<std::uint32_t>(0);  // the header
  }

  void PutText(std::string_view text) noexcept {
    PutBytes(std::as_bytes(std::span(text)));
    Put('\0');
  }
  void PutZeros(std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) Put('\0');
  }

  // For a size that is known later: Mark, then the content, then SetSize of the mark.
  std::size_t Mark() noexcept {
    Put<std::int32_t>(0);
    return At();
  }
  void SetSize(std::size_t mark) noexcept {
    const auto covered = static_cast<std::int32_t>(At() - mark);
    SetAt(mark - sizeof covered, covered);
  }

  // Writes the header and returns the packet's size; 0 if it did not fit.
  std::size_t Finish(MessageId id) noexcept {
    SetAt(0, std::array<std::uint16_t, 2>{static_cast<std::uint16_t>(id),
                                          static_cast<std::uint16_t>(At() - kHeaderSize)});
    return Written();
  }
};

}  // namespace styled::natnet
