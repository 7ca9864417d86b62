#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <span>

// For codecs only: reading and writing the little-endian bytes of a rig's binary protocol. Each
// protocol's own cursors add its counts, texts and headers. Nothing here allocates, blocks or
// throws. Pinned by the codecs' tests, tests/unit/natnet and tests/unit/qtm.
static_assert(std::endian::native == std::endian::little);

namespace styled::rigs {

// Reads from the front. Keeps the first error; after it all values are zero or empty. DecodeResult
// is the codec's enumeration, with kOk and kTruncated.
template <typename DecodeResult>
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}

  bool ok() const noexcept { return result_ == DecodeResult::kOk; }
  DecodeResult result() const noexcept { return result_; }
  std::size_t left() const noexcept { return bytes_.size(); }

  void Fail(DecodeResult why) noexcept {
    if (ok()) result_ = why;
    bytes_ = {};
  }
  std::span<const std::byte> Consume(std::size_t size) noexcept {
    if (size > bytes_.size()) {
      Fail(DecodeResult::kTruncated);
      return {};
    }
    const auto taken = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return taken;
  }
  // Reads a number or an array of floats.
  template <typename T>
  T Get() noexcept {
    T value{};
    const auto taken = Consume(sizeof(T));
    if (!taken.empty()) std::memcpy(&value, taken.data(), sizeof(T));
    return value;
  }

 protected:
  std::span<const std::byte> bytes_;

 private:
  DecodeResult result_ = DecodeResult::kOk;
};

// Writes from the front of `out`. After the first value that does not fit it writes nothing more.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> out) noexcept : out_(out) {}

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

 protected:
  // Overwrites the value at `at`; does nothing after a value that did not fit.
  template <typename T>
  void SetAt(std::size_t at, const T& value) noexcept {
    if (!full_) std::memcpy(&out_[at], &value, sizeof value);
  }
  // The bytes written so far; 0 if a value did not fit.
  std::size_t Written() const noexcept { return full_ ? 0 : size_; }
  // The bytes written so far, even if a value did not fit.
  std::size_t At() const noexcept { return size_; }

 private:
  std::span<std::byte> out_;
  std::size_t size_ = 0;
  bool full_ = false;
};

}  // namespace styled::rigs
