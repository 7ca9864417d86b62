#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// Styled's own rig protocol, as proto/styled/v1/WIRE.md: a 32-byte little-endian header and a
// protobuf payload per datagram, or per record of a TCP stream. Pure functions; any thread; nothing
// here allocates, blocks or throws. Pinned by tests/unit/native, fuzzed by tests/fuzz/native_fuzz.
namespace styled::native {

inline constexpr std::size_t kHeaderSize = 32;
inline constexpr std::size_t kMaxDatagramSize =
    65507;  // header included: what UDP over IPv4 carries
inline constexpr std::size_t kMaxPayloadSize = kMaxDatagramSize - kHeaderSize;

enum class Kind : std::uint8_t { kBody = 1, kSourceFrame = 2 };

// What one datagram says. `payload` is the serialized Body or SourceFrame and points into the
// bytes that were decoded: valid as long as they are.
struct Datagram {
  Kind kind = Kind::kSourceFrame;
  std::uint64_t session = 0;   // random, not 0, new at each start of the sender
  std::uint64_t sequence = 0;  // +1 per datagram of one performer and session, from 0
  std::span<const std::byte> payload;
};

// In the order in which the rules are checked, so that damage on the way is named as such: only
// what is needed to find the checksum is looked at before it.
enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kTooShort,        // fewer bytes than a header
  kTooLong,         // more bytes, or a header announcing more, than kMaxDatagramSize
  kBadMagic,        // not "STYD"
  kBadVersion,      // not 1
  kLengthMismatch,  // the header's length is not that of what follows it
  kBadChecksum,     // CRC-32C over header and payload
  kBadReserved,     // bytes 6 and 7 are not 0
  kBadKind,         // neither Body nor SourceFrame
  kNoSession,       // session id 0
  kCount            // the number of results, for tables of counters
};

// A word for counters and messages: "ok", "too_short", "bad_checksum", ...
std::string_view Name(DecodeResult result) noexcept;

// Reads one whole datagram or record. `datagram` is written only on kOk.
STYLED_REALTIME DecodeResult Decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept;

// Writes header and payload to the front of `out` and returns their size; 0, and nothing written,
// where `out` is too small, the payload larger than kMaxPayloadSize or the session 0. The payload
// may already lie in `out` behind the header (serialize it there to save the copy); no other
// overlap is allowed.
STYLED_REALTIME std::size_t Encode(const Datagram& datagram, std::span<std::byte> out) noexcept;

// CRC-32C (Castagnoli) as of RFC 3720 B.4; also what SourceFrame.body_crc holds.
STYLED_REALTIME std::uint32_t Crc32c(std::span<const std::byte> bytes) noexcept;

}  // namespace styled::native
