#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/cpp/doctor/address.h"

// Who holds which port of this machine, as /proc has it.
namespace styled::doctor {

// A bound UDP socket, or a listening one of TCP.
struct BoundSocket {
  bool stream = false;
  Endpoint local;
  std::uint64_t inode = 0;
  std::uint64_t waiting_bytes = 0;  // received by the kernel, not yet read by the program
  std::uint64_t drops = 0;          // UDP: found the buffer full, since the socket was made
  pid_t pid = 0;                    // 0: not readable; another user's, or in a container
  std::string program;              // its name; "" where pid is 0
};

// The rows of /proc/net/udp, udp6, tcp or tcp6 (proc(5)), owners not filled in. TCP: listening ones
// alone. Rows that cannot be read are left out. Pure; pinned by tests/unit/doctor/sockets_test.cpp.
std::vector<BoundSocket> ParseSocketTable(std::string_view text, bool stream);

// All of this machine's (of its network namespace), with their owners as far as they can be read.
std::vector<BoundSocket> ListSockets();

// "python3 (pid 4711)", or how to find out.
std::string Holder(const BoundSocket& socket);

}  // namespace styled::doctor
