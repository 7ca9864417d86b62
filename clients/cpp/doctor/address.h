#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// Addresses as text, the way people read and write them.
namespace styled::doctor {

// Host numeric: "127.0.0.1", "::1"; IPv4 within IPv6 is written as IPv4.
struct Endpoint {
  std::string host;
  std::uint16_t port = 0;
  friend auto operator<=>(const Endpoint&, const Endpoint&) = default;
};

// "127.0.0.1:7000" and "[::1]:7000". None where it is neither.
std::optional<Endpoint> ParseEndpoint(std::string_view text);
std::string ToString(const Endpoint& endpoint);
Endpoint FromSocket(const sockaddr_storage& address);
// Length 0: `endpoint` is no numeric address.
socklen_t ToSocket(const Endpoint& endpoint, sockaddr_storage& address);

bool IsWildcard(std::string_view host);  // 0.0.0.0, ::
bool IsLoopback(std::string_view host);  // 127.0.0.0/8, ::1
bool IsMulticast(std::string_view host);
bool IsNumeric(const std::string& host);

// What others sent or are called, for a terminal: no control characters, at most `limit` bytes.
std::string Printable(std::string_view text, std::size_t limit = 80);

}  // namespace styled::doctor
