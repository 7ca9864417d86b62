#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

// Conversion between addresses and their usual text form.
namespace styled::doctor {

// `host` is numeric: "127.0.0.1", "::1". An IPv4 address mapped into IPv6 is written as IPv4.
struct Endpoint {
  std::string host;
  std::uint16_t port = 0;
  friend auto operator<=>(const Endpoint&, const Endpoint&) = default;
};

// Parses "127.0.0.1:7000" and "[::1]:7000"; empty for any other text.
std::optional<Endpoint> ParseEndpoint(std::string_view text);
std::string ToString(const Endpoint& endpoint);
Endpoint FromSocket(const sockaddr_storage& address);
// Returns 0 if `endpoint` is not a numeric address.
socklen_t ToSocket(const Endpoint& endpoint, sockaddr_storage& address);

bool IsWildcard(std::string_view host);  // 0.0.0.0, ::
bool IsLoopback(std::string_view host);  // 127.0.0.0/8, ::1
bool IsMulticast(std::string_view host);
bool IsNumeric(const std::string& host);

// Makes a name or text received from the network safe for a terminal: no control characters, at
// most `limit` bytes.
std::string Printable(std::string_view text, std::size_t limit = 80);

}  // namespace styled::doctor
