#include "proto/rigs/qtm/packet.h"

#include <algorithm>

#include "proto/rigs/qtm/cursor.h"
#include "proto/rigs/result_name.h"

namespace styled::qtm {
namespace {

struct Header {
  std::uint32_t size = 0;
  PacketType type = PacketType::kError;
};

Header GetHeader(std::span<const std::byte> bytes) noexcept {
  Reader reader(bytes);
  Header header;
  header.size = reader.Get<std::uint32_t>();
  header.type = reader.Get<PacketType>();
  return header;
}

bool IsKnown(PacketType type) noexcept { return type <= PacketType::kQtmFile; }

// The sizes that a packet of this type may have.
std::size_t Smallest(PacketType type) noexcept {
  return kHeaderSize + (type == PacketType::kData ? 16U : type == PacketType::kEvent ? 1U : 0U);
}
std::size_t Largest(PacketType type) noexcept {
  switch (type) {
    case PacketType::kError:
    case PacketType::kCommand:
      return kMaxTextSize;
    case PacketType::kNoMoreData:
      return kHeaderSize;
    case PacketType::kEvent:
      return kHeaderSize + 1;
    case PacketType::kXml:
      return kMaxXmlSize;
    default:
      return kMaxPacketSize;
  }
}

// ASCII only, so that no locale changes how QTM's text is read.
char Lower(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool StartsWithFolded(std::string_view text, std::string_view start) noexcept {
  return text.size() >= start.size() &&
         std::equal(start.begin(), start.end(), text.begin(),
                    [](char a, char b) { return Lower(a) == Lower(b); });
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(result, {"ok", "too_short", "size_mismatch", "too_large", "bad_type",
                                   "truncated", "bad_count", "bad_time"});
}

DecodeResult DecodePacket(std::span<const std::byte> bytes, Packet& packet) noexcept {
  if (bytes.size() < kHeaderSize) return DecodeResult::kTooShort;
  const Header header = GetHeader(bytes);
  if (header.size != bytes.size()) return DecodeResult::kSizeMismatch;
  if (!IsKnown(header.type)) return DecodeResult::kBadType;
  if (header.size > Largest(header.type)) return DecodeResult::kTooLarge;
  if (header.size < Smallest(header.type)) return DecodeResult::kTruncated;
  packet.type = header.type;
  packet.payload = bytes.subspan(kHeaderSize);
  return DecodeResult::kOk;
}

rigs::Cut CutPacket(std::span<const std::byte> received, std::size_t& size) noexcept {
  if (received.size() < kHeaderSize) return rigs::Cut::kNeedMore;
  const Header header = GetHeader(received);
  if (!IsKnown(header.type) || header.size < Smallest(header.type) ||
      header.size > Largest(header.type)) {
    return rigs::Cut::kBroken;
  }
  if (received.size() < header.size) return rigs::Cut::kNeedMore;
  size = header.size;
  return rigs::Cut::kRecord;
}

std::string WhyBroken(std::span<const std::byte> received) {
  const Header header = GetHeader(received);
  if (!IsKnown(header.type)) {
    return "a packet of type " + std::to_string(static_cast<std::uint32_t>(header.type)) +
           ", expected 0 to 8 of QTM RT, little-endian (port " + std::to_string(kPort) + ")";
  }
  const std::string what = header.type == PacketType::kXml ? " (parameters)" : "";
  return "a packet of type " + std::to_string(static_cast<std::uint32_t>(header.type)) + what +
         " with " + std::to_string(header.size) + " bytes, expected " +
         std::to_string(Smallest(header.type)) + " to " + std::to_string(Largest(header.type));
}

std::string_view TextOf(std::span<const std::byte> payload) noexcept {
  const auto end = std::find(payload.begin(), payload.end(), std::byte{0});
  return {reinterpret_cast<const char*>(payload.data()),
          static_cast<std::size_t>(end - payload.begin())};
}

std::string ToString(std::string_view text) {
  std::string line(text.substr(0, 200));
  std::ranges::replace_if(
      line, [](char c) { return c < ' ' || c > '~'; }, '?');
  return line;
}

bool IsGreeting(std::string_view text) noexcept { return StartsWithFolded(text, kGreeting); }

bool AcceptsVersion(std::string_view text) noexcept {
  return StartsWithFolded(text, "Version set to");
}

std::size_t EncodeText(PacketType type, std::string_view text, std::span<std::byte> out) noexcept {
  Writer writer(type, out);
  writer.PutBytes(std::as_bytes(std::span(text)));
  writer.Put('\0');
  return writer.Finish();
}

std::size_t EncodeEvent(Event event, std::span<std::byte> out) noexcept {
  Writer writer(PacketType::kEvent, out);
  writer.Put(event);
  return writer.Finish();
}

std::size_t EncodeNoMoreData(std::span<std::byte> out) noexcept {
  return Writer(PacketType::kNoMoreData, out).Finish();
}

}  // namespace styled::qtm
