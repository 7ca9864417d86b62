#include "proto/rigs/livelinkface/live_link_face.h"

#include <bit>
#include <cstring>

namespace styled::live_link_face {
namespace {

constexpr std::uint8_t kVersion = 6;

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) noexcept : bytes_(bytes) {}
  std::size_t left() const noexcept { return bytes_.size(); }
  std::uint8_t Byte() noexcept {
    const auto byte = std::to_integer<std::uint8_t>(bytes_[0]);
    bytes_ = bytes_.subspan(1);
    return byte;
  }
  std::uint32_t Word() noexcept {
    std::uint32_t word = 0;
    for (int i = 0; i < 4; ++i) word = word << 8U | Byte();
    return word;
  }
  float Float() noexcept { return std::bit_cast<float>(Word()); }
  std::string_view Text(std::size_t size) noexcept {
    const std::string_view text(reinterpret_cast<const char*>(bytes_.data()), size);
    bytes_ = bytes_.subspan(size);
    return text;
  }

 private:
  std::span<const std::byte> bytes_;
};

class Writer {
 public:
  explicit Writer(std::span<std::byte> to) noexcept : to_(to) {}
  void Byte(std::uint32_t byte) noexcept { to_[size_++] = static_cast<std::byte>(byte & 0xFFU); }
  void Word(std::uint32_t word) noexcept {
    for (unsigned shift = 32; shift > 0; shift -= 8) Byte(word >> (shift - 8));
  }
  void Text(std::string_view text) noexcept {
    Word(static_cast<std::uint32_t>(text.size()));
    if (!text.empty()) std::memcpy(&to_[size_], text.data(), text.size());
    size_ += text.size();
  }
  std::size_t size() const noexcept { return size_; }

 private:
  std::span<std::byte> to_;
  std::size_t size_ = 0;
};

// The size of a text and of the length before it.
DecodeResult ReadText(Reader& reader, std::string_view& text) noexcept {
  if (reader.left() < 4) return DecodeResult::kNotFace;
  const std::uint32_t size = reader.Word();
  if (size > kMaxText) return DecodeResult::kBadText;
  if (reader.left() < size) return DecodeResult::kNotFace;
  text = reader.Text(size);
  return DecodeResult::kOk;
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  switch (result) {
    case DecodeResult::kOk:
      return "ok";
    case DecodeResult::kNotFace:
      return "not_face";
    case DecodeResult::kBadVersion:
      return "bad_version";
    case DecodeResult::kBadText:
      return "bad_text";
    case DecodeResult::kBadRate:
      return "bad_rate";
    case DecodeResult::kBadCount:
      return "bad_count";
    case DecodeResult::kBadSize:
      break;
  }
  return "bad_size";
}

DecodeResult Decode(std::span<const std::byte> datagram, Frame& frame) noexcept {
  Reader reader(datagram);
  if (reader.left() < 1) return DecodeResult::kNotFace;
  if (reader.Byte() != kVersion) return DecodeResult::kBadVersion;
  for (std::string_view* const text : {&frame.device, &frame.subject}) {
    if (const auto result = ReadText(reader, *text); result != DecodeResult::kOk) return result;
  }
  if (reader.left() < 16) return DecodeResult::kNotFace;
  frame.frame = static_cast<std::int32_t>(reader.Word());
  frame.subframe = reader.Float();
  frame.rate = static_cast<std::int32_t>(reader.Word());
  frame.rate_divisor = static_cast<std::int32_t>(reader.Word());
  if (frame.rate <= 0 || frame.rate_divisor <= 0) return DecodeResult::kBadRate;
  frame.has_face = reader.left() > 0;
  if (!frame.has_face) return DecodeResult::kOk;
  if (reader.Byte() != kValues) return DecodeResult::kBadCount;
  if (reader.left() != kValues * sizeof(float)) return DecodeResult::kBadSize;
  for (float& value : frame.values) value = reader.Float();
  return DecodeResult::kOk;
}

std::size_t Encode(const Frame& frame, std::span<std::byte> to) noexcept {
  const std::size_t texts = frame.device.size() + frame.subject.size();
  const std::size_t size = 25 + texts + (frame.has_face ? 1 + kValues * sizeof(float) : 0);
  if (frame.device.size() > kMaxText || frame.subject.size() > kMaxText || to.size() < size) {
    return 0;
  }
  Writer writer(to);
  writer.Byte(kVersion);
  writer.Text(frame.device);
  writer.Text(frame.subject);
  writer.Word(static_cast<std::uint32_t>(frame.frame));
  writer.Word(std::bit_cast<std::uint32_t>(frame.subframe));
  writer.Word(static_cast<std::uint32_t>(frame.rate));
  writer.Word(static_cast<std::uint32_t>(frame.rate_divisor));
  if (!frame.has_face) return writer.size();
  writer.Byte(kValues);
  for (const float value : frame.values) writer.Word(std::bit_cast<std::uint32_t>(value));
  return writer.size();
}

}  // namespace styled::live_link_face
