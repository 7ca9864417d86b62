#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// Styled's native rig protocol (proto/styled/v1/WIRE.md): a 32-byte little-endian header and a
// protobuf payload per datagram, or per record of a TCP stream. Pure functions; any thread; nothing
// here allocates, blocks or throws. Pinned by tests/unit/native, fuzzed by tests/fuzz/native_fuzz.
namespace styled::native {

inline constexpr std::size_t kHeaderSize = 32;
inline constexpr std::size_t kMaxDatagramSize =
    65507;  // header included: what UDP over IPv4 carries
inline constexpr std::size_t kMaxPayloadSize = kMaxDatagramSize - kHeaderSize;

enum class Kind : std::uint8_t { kBody = 1, kSourceFrame = 2 };

// The content of one datagram. `payload` is the serialized Body or SourceFrame; it points into the
// decoded bytes and is valid as long as they are.
struct Datagram {
  Kind kind = Kind::kSourceFrame;
  std::uint64_t session = 0;   // random, not 0, new at each start of the sender
  std::uint64_t sequence = 0;  // +1 per datagram of one performer and session, from 0
  std::span<const std::byte> payload;
};

// The results, in the order in which the rules are checked. The checksum comes before all fields
// that are not needed to find it, so that damage in transit is reported as such.
enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kTooShort,        // fewer bytes than a header
  kTooLong,         // the datagram, or the length in its header, exceeds kMaxDatagramSize
  kBadMagic,        // not "STYD"
  kBadVersion,      // not 1
  kLengthMismatch,  // the header's length differs from the size of the payload
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

// Writes header and payload to the front of `out` and returns their size. Returns 0 and writes
// nothing if `out` is too small, the payload is larger than kMaxPayloadSize, or the session is 0.
// The payload may already lie in `out` behind the header (serialize it there to save the copy); no
// other overlap is allowed.
STYLED_REALTIME std::size_t Encode(const Datagram& datagram, std::span<std::byte> out) noexcept;

}  // namespace styled::native
