#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <cstring>

#include "model/base/realtime.h"

namespace styled::source {

// The IP address of the machine that sent something, without the port. All zeros: unknown, or not
// needed (USB, and rigs whose translator distinguishes its senders itself).
using Machine = std::array<std::uint64_t, 2>;

STYLED_REALTIME inline Machine MachineOf(const sockaddr_storage& address) noexcept {
  Machine machine{};
  if (address.ss_family == AF_INET6) {
    std::memcpy(machine.data(), &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr, 16);
  } else if (address.ss_family == AF_INET) {
    std::memcpy(machine.data(), &reinterpret_cast<const sockaddr_in&>(address).sin_addr, 4);
  }
  return machine;
}

}  // namespace styled::source
