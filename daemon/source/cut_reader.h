#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "model/base/realtime.h"
#include "proto/rigs/cut.h"
#include "proto/rigs/mvn/stream.h"

namespace styled::source {

// Cuts a rig's TCP stream into its datagrams, as native::StreamReader does for the native protocol.
// The rig's protocol determines where each datagram ends. Works in the caller's buffer, which must
// outlive the reader and hold more than the largest datagram (with room for two, bytes are moved
// less often). Allocates nothing; one thread at a time.
class CutReader {
 public:
  using Result = rigs::Cut;
  // The size of the datagram at the front of the received bytes; written on kRecord only.
  using Cutter = Result (*)(std::span<const std::byte> received,
                            std::size_t& size) noexcept STYLED_REALTIME;

  explicit CutReader(std::span<std::byte> buffer, Cutter cut = mvn::CutRecord) noexcept
      : buffer_(buffer), cut_(cut) {}

  // Where to receive next. Moves an incomplete datagram to the front of the buffer, which
  // invalidates the records returned before.
  STYLED_REALTIME std::span<std::byte> Space() noexcept {
    if (begin_ > 0) {
      std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
                buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
      end_ -= begin_;
      begin_ = 0;
    }
    return buffer_.subspan(end_);
  }
  // Call after `size` bytes were received at the front of Space().
  STYLED_REALTIME void Received(std::size_t size) noexcept { end_ += size; }
  // The next whole datagram; `record` is written on kRecord only and is valid until Space().
  STYLED_REALTIME Result Next(std::span<const std::byte>& record) noexcept {
    const auto waiting = buffer_.subspan(begin_, end_ - begin_);
    std::size_t size = 0;
    const Result result = cut_(waiting, size);
    if (result != Result::kRecord) return result;
    record = waiting.first(size);
    begin_ += size;
    return result;
  }
  // Received bytes that do not yet form a whole datagram.
  std::size_t Pending() const noexcept { return end_ - begin_; }
  std::span<const std::byte> PendingBytes() const noexcept {
    return buffer_.subspan(begin_, end_ - begin_);
  }
  void Clear() noexcept { begin_ = end_ = 0; }

 private:
  std::span<std::byte> buffer_;
  Cutter cut_;
  std::size_t begin_ = 0, end_ = 0;
};

}  // namespace styled::source
