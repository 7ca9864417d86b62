#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "model/base/realtime.h"
#include "proto/rigs/mvn/stream.h"

namespace styled::source {

// Cuts a rig's TCP stream into its datagrams, as native::StreamReader does for the native protocol.
// The rig's protocol determines where each datagram ends. Works in the caller's buffer, which must
// hold two of the largest datagrams and outlive the reader. Allocates nothing; one thread at a
// time.
class CutReader {
 public:
  using Result = mvn::Cut;

  explicit CutReader(std::span<std::byte> buffer) noexcept : buffer_(buffer) {}

  // Where to receive next. Moves an incomplete datagram to the front of the buffer, which
  // invalidates the records handed out before.
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
    const Result result = mvn::CutRecord(waiting, size);
    if (result != Result::kRecord) return result;
    record = waiting.first(size);
    begin_ += size;
    return result;
  }
  // Bytes received that belong to no whole datagram yet.
  std::size_t Pending() const noexcept { return end_ - begin_; }

 private:
  std::span<std::byte> buffer_;
  std::size_t begin_ = 0, end_ = 0;
};

}  // namespace styled::source
