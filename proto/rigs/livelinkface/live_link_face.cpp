#include "proto/rigs/livelinkface/live_link_face.h"

#include "proto/rigs/big_endian.h"
#include "proto/rigs/result_name.h"

namespace styled::live_link_face {
namespace {

using Reader = rigs::BigEndianReader;

constexpr std::uint8_t kVersion = 6;

// Of a text with its length before it.
DecodeResult ReadText(Reader& reader, std::string_view& text) noexcept {
  if (reader.left() < 4) return DecodeResult::kNotFace;
  const std::uint32_t size = reader.U32();
  if (size > kMaxText) return DecodeResult::kBadText;
  if (reader.left() < size) return DecodeResult::kNotFace;
  text = reader.Text(size);
  return DecodeResult::kOk;
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(
      result, {"ok", "not_face", "bad_version", "bad_text", "bad_rate", "bad_count", "bad_size"});
}

DecodeResult Decode(std::span<const std::byte> datagram, Frame& frame) noexcept {
  Reader reader(datagram);
  if (reader.left() < 1) return DecodeResult::kNotFace;
  if (reader.U8() != kVersion) return DecodeResult::kBadVersion;
  for (std::string_view* const text : {&frame.device, &frame.subject}) {
    if (const auto result = ReadText(reader, *text); result != DecodeResult::kOk) return result;
  }
  if (reader.left() < 16) return DecodeResult::kNotFace;
  frame.frame = static_cast<std::int32_t>(reader.U32());
  frame.subframe = reader.Float();
  frame.rate = static_cast<std::int32_t>(reader.U32());
  frame.rate_divisor = static_cast<std::int32_t>(reader.U32());
  if (frame.rate <= 0 || frame.rate_divisor <= 0) return DecodeResult::kBadRate;
  frame.has_face = reader.left() > 0;
  if (!frame.has_face) return DecodeResult::kOk;
  if (reader.U8() != kValues) return DecodeResult::kBadCount;
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
  rigs::BigEndianWriter writer(to);
  writer.U8(kVersion);
  for (const std::string_view text : {frame.device, frame.subject}) {
    writer.U32(static_cast<std::uint32_t>(text.size()));
    writer.Text(text);
  }
  writer.U32(static_cast<std::uint32_t>(frame.frame));
  writer.Float(frame.subframe);
  writer.U32(static_cast<std::uint32_t>(frame.rate));
  writer.U32(static_cast<std::uint32_t>(frame.rate_divisor));
  if (!frame.has_face) return writer.size();
  writer.U8(kValues);
  writer.Floats(frame.values);
  return writer.size();
}

}  // namespace styled::live_link_face
