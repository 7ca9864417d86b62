#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "model/base/realtime.h"

// OptiTrack NatNet, bitstreams 2.7 to 4.2, and later ones as far as their sizes allow: UDP,
// little-endian, metres, right-handed, quaternions x, y, z, w. Pure functions; any thread; nothing
// here allocates, blocks or throws. Facts from the published behaviour of the protocol and from
// mje-nz/python_natnet (BSD-3), TimSchneider42/python-natnet-client (MIT), jeguzzi/natnet_py (MIT)
// and IMRCLab/libmotioncapture (MIT); none of their code is used. Pinned by tests/unit/natnet on
// captured packets of 3.0 (without skeletons) and on bytes written by hand, fuzzed by
// tests/fuzz/natnet.
namespace styled::natnet {

inline constexpr std::size_t kHeaderSize = 4;
inline constexpr std::size_t kMaxPacketSize = 65507;  // what UDP over IPv4 carries
inline constexpr std::uint16_t kCommandPort = 1510, kDataPort = 1511;

// One packet: u16 id, u16 size of the payload, payload.
enum class MessageId : std::uint16_t {
  kConnect = 0,
  kServerInfo = 1,
  kRequest = 2,
  kResponse = 3,
  kRequestModelDef = 4,
  kModelDef = 5,
  kRequestFrame = 6,
  kFrameOfData = 7,
  kMessageString = 8,
  kDisconnect = 9,
  kKeepAlive = 10,
  kDisconnectByTimeout = 11,
  kEchoRequest = 12,
  kEchoResponse = 13,
  kDiscovery = 14,
  kUnrecognized = 100  // decimal, as captured; mje-nz/python_natnet has it as 0x100
};

struct Packet {
  MessageId id = MessageId::kConnect;
  std::span<const std::byte> payload;  // points into the bytes that were decoded
};

// Version of an application or of a bitstream. The latter determines a frame's layout.
struct Version {
  std::uint8_t major = 0, minor = 0, build = 0, revision = 0;
  friend constexpr auto operator<=>(const Version&, const Version&) = default;
};
inline constexpr Version kOldest{2, 7};

// Why a packet or its payload is refused, in the order in which the rules are checked.
enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kTooShort,        // fewer bytes than a header
  kLengthMismatch,  // the header's size differs from that of the payload
  kOldVersion,      // a bitstream before kOldest, whose frames end differently
  kTruncated,       // a field extends past the end, or past its section's end
  kBadCount,        // a negative count, or more elements than the bytes left can hold
  kSizeMismatch,    // 4.1, 4.2: a section's elements end before its stated size
  kTrailing,        // bytes after the end, where none are allowed
  kCount            // the number of results, for tables
};

// A word for messages: "ok", "too_short", ...
std::string_view Name(DecodeResult result) noexcept;

// Splits a datagram into id and payload; any id is accepted. Writes `packet` only on kOk.
STYLED_REALTIME DecodeResult DecodePacket(std::span<const std::byte> bytes,
                                          Packet& packet) noexcept;

// Writes header and payload to the front of `out` and returns their size. Returns 0 if they do not
// fit; the content of `out` is unspecified then, as with the other encoders.
STYLED_REALTIME std::size_t EncodePacket(const Packet& packet, std::span<std::byte> out) noexcept;

}  // namespace styled::natnet
