#include "proto/rigs/natnet/packet.h"

#include "proto/rigs/natnet/cursor.h"

namespace styled::natnet {

std::string_view Name(DecodeResult result) noexcept {
  switch (result) {
    case DecodeResult::kOk:
      return "ok";
    case DecodeResult::kTooShort:
      return "too_short";
    case DecodeResult::kLengthMismatch:
      return "length_mismatch";
    case DecodeResult::kOldVersion:
      return "old_version";
    case DecodeResult::kTruncated:
      return "truncated";
    case DecodeResult::kBadCount:
      return "bad_count";
    case DecodeResult::kSizeMismatch:
      return "size_mismatch";
    case DecodeResult::kTrailing:
      return "trailing";
    case DecodeResult::kCount:
      break;
  }
  return "unknown";
}

DecodeResult DecodePacket(std::span<const std::byte> bytes, Packet& packet) noexcept {
  if (bytes.size() < kHeaderSize) return DecodeResult::kTooShort;
  Reader reader(bytes);
  const auto id = reader.Get<std::uint16_t>();
  const auto size = reader.Get<std::uint16_t>();
  if (size != reader.left()) return DecodeResult::kLengthMismatch;
  packet.id = MessageId{id};
  packet.payload = bytes.subspan(kHeaderSize);
  return DecodeResult::kOk;
}

std::size_t EncodePacket(const Packet& packet, std::span<std::byte> out) noexcept {
  Writer writer(out);
  writer.PutBytes(packet.payload);
  return writer.Finish(packet.id);
}

}  // namespace styled::natnet
