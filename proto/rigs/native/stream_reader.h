#pragma once

#include <cassert>
#include <cstddef>
#include <span>

#include "proto/rigs/native/datagram.h"

namespace styled::native {

// Cuts a TCP stream into records, one per datagram, for Decode(). Works in the caller's buffer,
// which must outlive it; never allocates. One per connection; one thread at a time.
//
//   const auto n = read(socket, reader.Space());  reader.Received(n);
//   while (reader.Next(record) == StreamReader::Result::kRecord) Decode(record, ...);
//
// The stream stays readable as long as the headers' magic, version and length are plausible. A
// record with a wrong checksum is still returned (Decode() refuses it); if its length was damaged,
// too, the next header shows it.
class StreamReader {
 public:
  enum class [[nodiscard]] Result {
    kRecord,    // `record` is one whole record
    kNeedMore,  // receive into Space() and try again
    kBroken     // nothing after this point can be trusted: close the connection; Broken() says why
  };

  // `buffer` holds at least kMaxDatagramSize bytes; twice that halves the copying.
  explicit StreamReader(std::span<std::byte> buffer) noexcept : buffer_(buffer) {
    assert(buffer.size() >= kMaxDatagramSize);
  }

  // Where to receive next; never empty after Next() returned kNeedMore. Moves an incomplete record
  // to the front if room is short, which invalidates the spans from Next().
  STYLED_REALTIME std::span<std::byte> Space() noexcept;

  // Call after `size` bytes were received at the front of Space(); size <= Space().size().
  STYLED_REALTIME void Received(std::size_t size) noexcept;

  // The next record of what was received; `record` is written on kRecord only and is valid until
  // the next call of Space().
  STYLED_REALTIME Result Next(std::span<const std::byte>& record) noexcept;

  // kOk, or the rule that the stream broke: kBadMagic, kBadVersion, kTooLong.
  DecodeResult Broken() const noexcept { return broken_; }

  // Bytes received that belong to no whole record yet. If not 0 when the connection ends, the
  // stream was cut short.
  std::size_t Pending() const noexcept { return end_ - begin_; }

 private:
  std::span<std::byte> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // the bytes received and not yet returned
  DecodeResult broken_ = DecodeResult::kOk;
};

}  // namespace styled::native
