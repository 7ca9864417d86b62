#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "model/base/status.h"

namespace styled::config {

// A USB device's vendor and product id, e.g. "1209:7690": four hexadecimal digits each.
struct UsbId {
  std::uint16_t vendor = 0, product = 0;
  friend bool operator==(const UsbId&, const UsbId&) = default;
};
Result<UsbId> ParseUsbId(std::string_view text);
std::string ToText(const UsbId& id);

// Whether `host` is an IPv4 or IPv6 address, not a name.
bool IsNumeric(const std::string& host);

// Whether only this machine can reach a ZeroMQ endpoint: ipc://, inproc://, or tcp:// to
// 127.0.0.0/8, [::1] or localhost.
bool IsLocal(std::string_view endpoint);

// Ok, or an error that says why `endpoint` cannot be bound by ZeroMQ. Expects tcp://HOST:PORT or
// ipc://PATH with a path of 1 to 107 characters.
Status CheckEndpoint(std::string_view endpoint);

}  // namespace styled::config
