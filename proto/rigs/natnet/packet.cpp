#include "proto/rigs/natnet/packet.h"

#include "proto/rigs/natnet/cursor.h"
#include "proto/rigs/result_name.h"

namespace styled::natnet {

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(result, {"ok", "too_short", "length_mismatch", "old_version", "truncated",
                                   "bad_count", "size_mismatch", "trailing"});
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
