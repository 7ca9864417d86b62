#include "daemon/config/address.h"

#include <arpa/inet.h>

#include <array>
#include <charconv>
#include <cstdio>

#include "daemon/runtime/host_port.h"
#include "model/base/text.h"

namespace styled::config {
namespace {

constexpr std::string_view kTcp = "tcp://";
constexpr std::string_view kIpc = "ipc://";
constexpr std::size_t kShown = 128;  // bytes of an address that errors quote; a path has up to 107

bool StartsWith(std::string_view text, std::string_view prefix) {
  return text.substr(0, prefix.size()) == prefix;
}

}  // namespace

Result<UsbId> ParseUsbId(std::string_view text) {
  const auto parse = [](std::string_view digits, std::uint16_t& value) {
    const char* const end = digits.data() + digits.size();
    return digits.size() == 4 && std::from_chars(digits.data(), end, value, 16).ptr == end;
  };
  UsbId id;
  if (text.size() == 9 && text[4] == ':' && parse(text.substr(0, 4), id.vendor) &&
      parse(text.substr(5), id.product)) {
    return id;
  }
  return Status::Error("\"" + Printable(text, kShown) +
                       "\" is not a USB id: expected VENDOR:PRODUCT in hexadecimal, e.g. "
                       "\"1209:7690\"");
}

std::string ToText(const UsbId& id) {
  std::array<char, 10> text{};
  std::snprintf(text.data(), text.size(), "%04x:%04x", id.vendor, id.product);
  return text.data();
}

bool IsNumeric(const std::string& host) {
  in6_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

bool IsLocal(std::string_view endpoint) {
  if (StartsWith(endpoint, kIpc) || StartsWith(endpoint, "inproc://")) return true;
  if (!StartsWith(endpoint, kTcp)) return false;
  const auto parsed = runtime::ParseHostPort(endpoint.substr(kTcp.size()));
  if (!parsed.ok()) return false;
  const std::string& host = parsed.value().host;
  if (host == "localhost" || host == "::1") return true;
  // 127.0.0.0/8, digits and dots only: "127.evil.example" is a host name.
  return StartsWith(host, "127.") && host.find_first_not_of("0123456789.") == std::string::npos;
}

Status CheckEndpoint(std::string_view endpoint) {
  if (StartsWith(endpoint, kIpc)) {
    const std::size_t length = endpoint.size() - kIpc.size();
    if (length >= 1 && length <= 107) return Status::Ok();
    return Status::Error("\"" + Printable(endpoint, kShown) +
                         "\": the path must have 1 to 107 characters");
  }
  // Port 0 means any port, as everywhere in the configuration; ZmqSocket::Bind() writes it as
  // libzmq's *.
  if (StartsWith(endpoint, kTcp)) {
    const auto parsed = runtime::ParseHostPort(endpoint.substr(kTcp.size()));
    if (parsed.ok() && parsed.value().host == "localhost") {
      return Status::Error("\"" + std::string(endpoint) +
                           "\": ZeroMQ does not bind to host names; expected 127.0.0.1");
    }
    return parsed.ok() ? Status::Ok() : parsed.status();
  }
  return Status::Error("\"" + Printable(endpoint, kShown) +
                       "\" is not an endpoint: expected tcp://HOST:PORT or ipc://PATH");
}

}  // namespace styled::config
