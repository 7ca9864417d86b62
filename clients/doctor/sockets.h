#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/doctor/address.h"

// Which program holds which port of this machine, from /proc.
namespace styled::doctor {

// A bound UDP socket or a listening TCP socket.
struct BoundSocket {
  bool stream = false;
  Endpoint local;
  std::uint64_t inode = 0;
  std::uint64_t waiting_bytes = 0;  // received by the kernel, not yet read by the program
  std::uint64_t drops = 0;  // UDP: datagrams lost to a full buffer since the socket was created
  pid_t pid = 0;            // 0: unknown; the process of another user, or in a container
  std::string program;      // its name; "" if pid is 0
};

// Parses /proc/net/udp, udp6, tcp or tcp6 (proc(5)). Owners are not filled in. For TCP, only
// listening sockets are returned. Unreadable rows are skipped. Pure; pinned by
// tests/unit/doctor/sockets_test.cpp.
std::vector<BoundSocket> ParseSocketTable(std::string_view text, bool stream);

// All sockets of this machine's network namespace, with their owners as far as /proc permits.
std::vector<BoundSocket> ListSockets();

// "python3 (pid 4711)"; if the owner is unknown, how to find it.
std::string Holder(const BoundSocket& socket);

}  // namespace styled::doctor
