#include "proto/rigs/native/stream_reader.h"

#include <algorithm>
#include <cstring>

#include "proto/rigs/native/header.h"

namespace styled::native {

std::span<std::byte> StreamReader::Space() noexcept {
  if (begin_ == end_) {
    begin_ = end_ = 0;
  } else if (begin_ != 0 && buffer_.size() - begin_ < kMaxDatagramSize) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  return buffer_.subspan(end_);
}

void StreamReader::Received(std::size_t size) noexcept {
  assert(size <= buffer_.size() - end_);
  end_ += size;
}

StreamReader::Result StreamReader::Next(std::span<const std::byte>& record) noexcept {
  const auto break_off = [this](DecodeResult reason) {
    broken_ = reason;
    return Result::kBroken;
  };
  if (broken_ != DecodeResult::kOk) return Result::kBroken;
  const std::span<const std::byte> received = buffer_.subspan(begin_, end_ - begin_);

  // Refuse a wrong first byte at once: the rest of the header may never arrive.
  const std::size_t magic_size = std::min(received.size(), header::kMagicText.size());
  if (magic_size != 0 && std::memcmp(received.data(), header::kMagicText.data(), magic_size) != 0) {
    return break_off(DecodeResult::kBadMagic);
  }
  if (received.size() < kHeaderSize) return Result::kNeedMore;
  if (header::Read<std::uint8_t>(received, header::kVersion) != header::kVersionNumber) {
    return break_off(DecodeResult::kBadVersion);
  }
  const std::size_t length = header::Read<std::uint32_t>(received, header::kLength);
  if (length > kMaxPayloadSize) return break_off(DecodeResult::kTooLong);
  if (received.size() < kHeaderSize + length) return Result::kNeedMore;
  record = received.first(kHeaderSize + length);
  begin_ += kHeaderSize + length;
  return Result::kRecord;
}

}  // namespace styled::native
