#include "clients/doctor/address.h"

#include <arpa/inet.h>

#include <array>
#include <charconv>

namespace styled::doctor {
namespace {

constexpr std::string_view kMapped = "::ffff:";  // IPv4 mapped into IPv6

}  // namespace

std::optional<Endpoint> ParseEndpoint(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  if (host.front() == '[' && host.back() == ']' && host.size() > 2) {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return std::nullopt;
  }
  Endpoint out{std::string(host), 0};
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), out.port);
  if (error != std::errc() || end != port.data() + port.size()) return std::nullopt;
  return out;
}

std::string ToString(const Endpoint& endpoint) {
  const bool v6 = endpoint.host.find(':') != std::string::npos;
  return (v6 ? "[" + endpoint.host + "]" : endpoint.host) + ":" + std::to_string(endpoint.port);
}

Endpoint FromSocket(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  Endpoint out;
  bool mapped = false;
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &v4.sin_addr, text.data(), text.size());
    out.port = ntohs(v4.sin_port);
  } else if (address.ss_family == AF_INET6) {
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
    inet_ntop(AF_INET6, &v6.sin6_addr, text.data(), text.size());
    out.port = ntohs(v6.sin6_port);
    mapped = IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr);
  }
  out.host = text.data();
  if (mapped) out.host.erase(0, kMapped.size());
  return out;
}

socklen_t ToSocket(const Endpoint& endpoint, sockaddr_storage& address) {
  address = {};
  auto& v4 = reinterpret_cast<sockaddr_in&>(address);
  if (inet_pton(AF_INET, endpoint.host.c_str(), &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = htons(endpoint.port);
    return sizeof v4;
  }
  auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
  if (inet_pton(AF_INET6, endpoint.host.c_str(), &v6.sin6_addr) != 1) return 0;
  v6.sin6_family = AF_INET6;
  v6.sin6_port = htons(endpoint.port);
  return sizeof v6;
}

bool IsWildcard(std::string_view host) { return host == "0.0.0.0" || host == "::"; }

bool IsLoopback(std::string_view host) { return host.starts_with("127.") || host == "::1"; }

bool IsMulticast(std::string_view host) {
  in_addr v4{};
  if (inet_pton(AF_INET, std::string(host).c_str(), &v4) == 1) {
    return IN_MULTICAST(ntohl(v4.s_addr));
  }
  return host.starts_with("ff") && host.find(':') != std::string_view::npos;
}

bool IsNumeric(const std::string& host) {
  sockaddr_storage address;
  return ToSocket({host, 0}, address) > 0;
}

std::string Printable(std::string_view text, std::size_t limit) {
  std::string out(text.substr(0, limit));
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < ' ' || static_cast<unsigned char>(c) > '~') c = '?';
  }
  return out;
}

}  // namespace styled::doctor
