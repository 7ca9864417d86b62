#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "clients/doctor/address.h"
#include "clients/doctor/interfaces.h"
#include "clients/doctor/listener.h"
#include "model/base/status.h"

// Captures UDP at the interfaces: before any firewall, and also for ports that other programs hold.
namespace styled::doctor {

struct Captured {
  Endpoint from, to;
  std::span<const std::byte> payload;
  bool cut = false;  // a fragment: `payload` is only the first part of the datagram
};

// Parses an IPv4 or IPv6 packet that contains UDP. Empty for other or malformed packets and for
// fragments without the UDP header. Pure; pinned by tests/unit/doctor/capture_test.cpp.
std::optional<Captured> ParsePacket(std::span<const std::byte> packet);

// Writes datagrams into Notebook::seen if they go to one of `ports` or have a format that the
// daemon accepts. Fails without CAP_NET_RAW, which usually only root has.
Result<std::vector<std::unique_ptr<Listener>>> MakeCapture(const std::vector<Interface>& interfaces,
                                                           const std::set<std::uint16_t>& ports);

}  // namespace styled::doctor
