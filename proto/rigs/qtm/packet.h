#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "model/base/realtime.h"
#include "proto/rigs/cut.h"

// Qualisys Track Manager's real-time protocol (QTM RT), versions 1.19 to 1.25, over TCP on the
// little-endian port. A client connects, receives a greeting, requests a version and parameters
// (XML), and then a stream of data packets. Pure functions; any thread; except for ToString nothing
// in this header allocates, blocks or throws. Facts from the published description of the protocol
// (1.20), and from the behaviour of qualisys_cpp_sdk, qualisys_python_sdk and qualisys-rt (all
// MIT); none of their code is used. Pinned by tests/unit/qtm on bytes written by hand and by
// tests/witness/qtm, fuzzed by tests/fuzz/qtm.
namespace styled::qtm {

inline constexpr std::uint16_t kPort = 22223;  // little-endian; 22224 is big-endian
inline constexpr std::size_t kHeaderSize = 8;
// The largest packet with its header: a record of a recording (proto/recording/block.h, 2 MiB)
// minus room for the record's other fields.
inline constexpr std::size_t kMaxPacketSize = (2U << 20U) - (64U << 10U);
// The largest XML, which is the largest packet. A skeleton with fingers has 120 KB of it, and QTM
// lists all its skeletons, including those that are left out here: this is enough for 68. It bounds
// a receiver's memory per connection; packets beyond kMaxPacketSize are not recorded.
inline constexpr std::size_t kMaxXmlSize = 8U << 20U;
inline constexpr std::size_t kMaxTextSize = 4096;  // of a command's or an error's packet

// Limits of a frame and of the XML: further skeletons are left out, and a skeleton with more
// segments is refused.
inline constexpr std::size_t kMaxSkeletons = 16, kMaxSegments = 128;

// One packet: u32 size of all of it, u32 type, payload.
enum class PacketType : std::uint32_t {
  kError = 0,    // text
  kCommand = 1,  // text: a command, or the answer to one
  kXml = 2,      // text
  kData = 3,     // frame.h
  kNoMoreData = 4,
  kC3dFile = 5,
  kEvent = 6,  // u8
  kDiscover = 7,
  kQtmFile = 8
};

struct Packet {
  PacketType type = PacketType::kCommand;
  std::span<const std::byte> payload;  // points into the bytes that were decoded
};

// Events in QTM; others are numbered up to 16.
enum class Event : std::uint8_t {
  kConnected = 1,  // a connection to the cameras, or an opened file
  kConnectionClosed = 2,
  kCaptureStarted = 3,
  kCaptureStopped = 4,
  kRtFromFileStarted = 8,
  kRtFromFileStopped = 9,
  kShuttingDown = 12
};

// The protocol's version; the major number is 1. From 1.21 on skeletons are nested in the XML.
inline constexpr int kNewestMinor = 25, kOldestMinor = 19, kNestedMinor = 21;

// Why a packet is refused, in the order in which the rules are checked.
enum class [[nodiscard]] DecodeResult : std::uint8_t {
  kOk,
  kTooShort,      // fewer bytes than a header
  kSizeMismatch,  // the header's size differs from that of the bytes
  kTooLarge,      // more bytes than this type of packet may have
  kBadType,       // no such type
  kTruncated,     // a field extends past the end of its component, or of the packet
  kBadCount,      // more elements than the bytes left can hold
  kBadTime,       // a timestamp that is negative, or 30 years or more
  kCount          // the number of results, for tables
};
// A word for messages: "ok", "too_short", ...
std::string_view Name(DecodeResult result) noexcept;

// Splits one packet into type and payload; writes `packet` only on kOk.
STYLED_REALTIME DecodeResult DecodePacket(std::span<const std::byte> bytes,
                                          Packet& packet) noexcept;

// Finds the packet at the front of a stream's bytes; writes `size` on kRecord only. A header with
// an unknown type, or with a size that its type may not have, is kBroken before its payload has
// arrived.
STYLED_REALTIME rigs::Cut CutPacket(std::span<const std::byte> received,
                                    std::size_t& size) noexcept;
// Why the header at the front is kBroken, and what was expected, for a message.
std::string WhyBroken(std::span<const std::byte> received);

// The text of an error, a command or XML: up to its NUL, or the end of the payload.
STYLED_REALTIME std::string_view TextOf(std::span<const std::byte> payload) noexcept;
// The same on one line for messages, at most 200 bytes, with '?' for everything but printable
// ASCII.
std::string ToString(std::string_view text);

// Whether a server's text, in any case of letters, greets a client, or accepts the requested
// version.
STYLED_REALTIME bool IsGreeting(std::string_view text) noexcept;
STYLED_REALTIME bool AcceptsVersion(std::string_view text) noexcept;
inline constexpr std::string_view kGreeting = "QTM RT Interface connected";

// Each writes a packet to the front of `out` and returns its size; 0 if it does not fit. The
// content of `out` is unspecified then.
STYLED_REALTIME std::size_t EncodeText(PacketType type, std::string_view text,
                                       std::span<std::byte> out) noexcept;
STYLED_REALTIME std::size_t EncodeEvent(Event event, std::span<std::byte> out) noexcept;
STYLED_REALTIME std::size_t EncodeNoMoreData(std::span<std::byte> out) noexcept;

}  // namespace styled::qtm
