#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "clients/cpp/doctor/address.h"
#include "clients/cpp/doctor/interfaces.h"
#include "clients/cpp/doctor/listener.h"
#include "model/base/status.h"

// UDP as it comes to the interfaces: before firewalls, and to ports that another program holds.
namespace styled::doctor {

struct Captured {
  Endpoint from, to;
  std::span<const std::byte> payload;
  bool cut = false;  // only the first part of it: a fragment
};

// An IP packet (4 or 6) with UDP in it; none where it is another, broken, or a fragment without the
// header. Pure; pinned by tests/unit/doctor/capture_test.cpp.
std::optional<Captured> ParsePacket(std::span<const std::byte> packet);

// Writes into Notebook::seen what goes to one of `ports` or has a format that the daemon takes.
// Errors: the right to do so (CAP_NET_RAW) is root's.
Result<std::vector<std::unique_ptr<Listener>>> MakeCapture(const std::vector<Interface>& interfaces,
                                                           const std::set<std::uint16_t>& ports);

}  // namespace styled::doctor
