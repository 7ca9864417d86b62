#include "proto/rigs/native/datagram.h"

#include <array>
#include <cstring>

#include "model/base/crc32c.h"
#include "proto/rigs/native/header.h"
#include "proto/rigs/result_name.h"

namespace styled::native {
namespace {

// The checksum of a whole datagram, with its own field counted as 0.
std::uint32_t Checksum(std::span<const std::byte> bytes) noexcept {
  constexpr std::array<std::byte, header::kCrcSize> kZero{};
  Crc32cSum crc;
  crc.process_bytes(bytes.data(), header::kCrc);
  crc.process_bytes(kZero.data(), kZero.size());
  const auto rest = bytes.subspan(header::kCrc + header::kCrcSize);
  crc.process_bytes(rest.data(), rest.size());
  return crc.checksum();
}

}  // namespace

std::string_view Name(DecodeResult result) noexcept {
  return rigs::ResultName(
      result, {"ok", "too_short", "too_long", "bad_magic", "bad_version", "length_mismatch",
               "bad_checksum", "bad_reserved", "bad_kind", "no_session"});
}

DecodeResult Decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept {
  if (bytes.size() < kHeaderSize) return DecodeResult::kTooShort;
  if (bytes.size() > kMaxDatagramSize) return DecodeResult::kTooLong;
  if (std::memcmp(bytes.data(), header::kMagicText.data(), header::kMagicText.size()) != 0) {
    return DecodeResult::kBadMagic;
  }
  if (header::Read<std::uint8_t>(bytes, header::kVersion) != header::kVersionNumber) {
    return DecodeResult::kBadVersion;
  }
  const std::size_t length = header::Read<std::uint32_t>(bytes, header::kLength);
  if (length > kMaxPayloadSize) return DecodeResult::kTooLong;
  if (length != bytes.size() - kHeaderSize) return DecodeResult::kLengthMismatch;
  if (header::Read<std::uint32_t>(bytes, header::kCrc) != Checksum(bytes)) {
    return DecodeResult::kBadChecksum;
  }
  if (header::Read<std::uint16_t>(bytes, header::kReserved) != 0) return DecodeResult::kBadReserved;
  const Kind kind{header::Read<std::uint8_t>(bytes, header::kKind)};
  if (kind != Kind::kBody && kind != Kind::kSourceFrame) return DecodeResult::kBadKind;
  const auto session = header::Read<std::uint64_t>(bytes, header::kSession);
  if (session == 0) return DecodeResult::kNoSession;

  datagram.kind = kind;
  datagram.session = session;
  datagram.sequence = header::Read<std::uint64_t>(bytes, header::kSequence);
  datagram.payload = bytes.subspan(kHeaderSize);
  return DecodeResult::kOk;
}

std::size_t Encode(const Datagram& datagram, std::span<std::byte> out) noexcept {
  const std::size_t length = datagram.payload.size();
  const std::size_t size = kHeaderSize + length;
  if (length > kMaxPayloadSize || size > out.size() || datagram.session == 0) return 0;

  std::byte* const payload = out.data() + kHeaderSize;
  if (length != 0 && payload != datagram.payload.data()) {
    std::memcpy(payload, datagram.payload.data(), length);
  }
  std::memcpy(out.data(), header::kMagicText.data(), header::kMagicText.size());
  header::Write<std::uint8_t>(out, header::kVersion, header::kVersionNumber);
  header::Write<std::uint8_t>(out, header::kKind, static_cast<std::uint8_t>(datagram.kind));
  header::Write<std::uint16_t>(out, header::kReserved, 0);
  header::Write<std::uint32_t>(out, header::kLength, static_cast<std::uint32_t>(length));
  header::Write<std::uint64_t>(out, header::kSession, datagram.session);
  header::Write<std::uint64_t>(out, header::kSequence, datagram.sequence);
  header::Write<std::uint32_t>(out, header::kCrc, Checksum(out.first(size)));
  return size;
}

}  // namespace styled::native
