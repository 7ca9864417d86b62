#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "proto/rigs/natnet/packet.h"

// The messages between client and server other than models and frames.
namespace styled::natnet {

// CONNECT (and DISCOVERY): identifies the client. It occurs in three shapes: empty or a text
// ("Ping"); the sender's record (a captured NatNetLib 3.0: 264 bytes, name and two versions); and
// from 4.0 on 270 bytes that begin with "Ping" and request a bitstream.
struct Connect {
  enum class Shape : std::uint8_t { kText, kRecord, kBitstream };
  Shape shape = Shape::kRecord;
  std::string_view name;         // name or text; cut to 255 when encoded
  Version application, natnet;   // kRecord, zero otherwise
  bool subscribed_only = false;  // kBitstream: send only subscribed data
  Version bitstream;             // kBitstream: the requested one; zero = the server's own
};
// Every payload is a CONNECT of some shape. Views point into `payload`.
STYLED_REALTIME void DecodeConnect(std::span<const std::byte> payload, Connect& connect) noexcept;
STYLED_REALTIME std::size_t EncodeConnect(const Connect& connect,
                                          std::span<std::byte> out) noexcept;

// SERVER INFO: identifies the server and its bitstream.
struct ServerInfo {
  std::string_view name;     // application
  Version application;       // its version
  Version natnet;            // the bitstream of everything sent from now on
  struct Connection {        // from 3.0 on
    std::uint64_t clock_hz;  // frequency of the ticks in frames and echoes
    std::uint16_t data_port;
    bool multicast;  // frames go to the group, else to each client that connected
    std::array<std::uint8_t, 4> group;  // IPv4, as written: 239.255.42.99
  };
  std::optional<Connection> connection;
};
// `info` is unspecified unless kOk; views point into `payload`. The bytes after the name's NUL are
// often garbage.
STYLED_REALTIME DecodeResult DecodeServerInfo(std::span<const std::byte> payload,
                                              ServerInfo& info) noexcept;
STYLED_REALTIME std::size_t EncodeServerInfo(const ServerInfo& info,
                                             std::span<std::byte> out) noexcept;

// REQUEST: a command as text, e.g. "FrameRate"; up to a NUL or the payload's end.
STYLED_REALTIME std::string_view DecodeRequest(std::span<const std::byte> payload) noexcept;
// RESPONSE to a request for a number, e.g. frames per second. Other responses have no common form.
STYLED_REALTIME std::size_t EncodeNumber(float number, std::span<std::byte> out) noexcept;

// ECHO RESPONSE: the client's timestamp from the request, and the server's ticks at its arrival.
struct Echo {
  std::uint64_t client = 0, server = 0;
};
STYLED_REALTIME DecodeResult DecodeEchoRequest(std::span<const std::byte> payload,
                                               Echo& echo) noexcept;  // writes `client`
STYLED_REALTIME std::size_t EncodeEchoResponse(const Echo& echo, std::span<std::byte> out) noexcept;

}  // namespace styled::natnet
