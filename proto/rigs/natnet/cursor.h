#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "proto/rigs/natnet/packet.h"

// For the codec only: reading and writing little-endian bytes.
static_assert(std::endian::native == std::endian::little);

namespace styled::natnet {

// From this version on, sections and data sets state their sizes, and a frame has assets and PTP
// time.
inline constexpr Version kSized{4, 1};
// Whether every element of the bitstream is known. Of a later one only the parts that its sizes
// delimit are read.
constexpr bool IsKnown(Version version) noexcept { return version < Version{4, 3}; }

// Reads from the front. Keeps the first error; after it all values are zero or empty.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

  bool ok() const noexcept { return result_ == DecodeResult::kOk; }
  DecodeResult result() const noexcept { return result_; }
  std::size_t left() const noexcept { return bytes_.size(); }

  void Fail(DecodeResult why) noexcept {
    if (ok()) result_ = why;
    bytes_ = {};
  }

  std::span<const std::byte> Take(std::size_t size) noexcept {
    if (size > bytes_.size()) {
      Fail(DecodeResult::kTruncated);
      return {};
    }
    const auto taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }
  void Skip(std::size_t size) noexcept { Take(size); }

  // Reads a number or an array of floats.
  template <typename T>
  T Get() noexcept {
    T value{};
    const auto taken = Take(sizeof(T));
    if (!taken.empty()) std::memcpy(&value, taken.data(), sizeof(T));
    return value;
  }

  // Reads a text and its terminating NUL.
  std::string_view GetText() noexcept {
    const auto end = std::find(bytes_.begin(), bytes_.end(), std::byte{0});
    if (end == bytes_.end()) {
      Fail(DecodeResult::kTruncated);
      return {};
    }
    const auto taken = Take(static_cast<std::size_t>(end - bytes_.begin()) + 1);
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

  // Sub splits off a part with its own end. Join takes over the part's error after it was read;
  // `exact`: it must have been read to its end.
  Reader Sub(std::size_t size) noexcept { return Reader(Take(size)); }
  void Join(const Reader& part, bool exact) noexcept {
    if (!part.ok()) return Fail(part.result());
    if (exact && part.left() > 0) Fail(DecodeResult::kSizeMismatch);
  }

 private:
  std::span<const std::byte> bytes_;
  DecodeResult result_ = DecodeResult::kOk;
};

// Writes a packet from the front of `out`. After the first value that does not fit nothing more is
// written.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept
      : out_(out.first(std::min(out.size(), kMaxPacketSize))) {
    Put<std::uint32_t>(0);  // the header
  }

  void PutBytes(std::span<const std::byte> bytes) noexcept {
    full_ = full_ || bytes.size() > out_.size() - size_;
    if (full_ || bytes.empty()) return;
    std::memcpy(&out_[size_], bytes.data(), bytes.size());
    size_ += bytes.size();
  }
  template <typename T>
  void Put(const T& value) noexcept {
    PutBytes(std::as_bytes(std::span(&value, 1)));
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
    return size_;
  }
  void SetSize(std::size_t mark) noexcept {
    if (full_) return;
    const auto covered = static_cast<std::int32_t>(size_ - mark);
    std::memcpy(&out_[mark - sizeof covered], &covered, sizeof covered);
  }

  // Writes the header and returns the packet's size; 0 if it did not fit.
  std::size_t Finish(MessageId id) noexcept {
    if (full_) return 0;
    const std::array<std::uint16_t, 2> header{static_cast<std::uint16_t>(id),
                                              static_cast<std::uint16_t>(size_ - kHeaderSize)};
    std::memcpy(out_.data(), header.data(), kHeaderSize);
    return size_;
  }

 private:
  std::span<std::byte> out_;
  std::size_t size_ = 0;
  bool full_ = false;
};

}  // namespace styled::natnet
