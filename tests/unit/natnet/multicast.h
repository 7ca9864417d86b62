#pragma once

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "model/base/descriptor.h"

// Multicast on the loopback interface, which not every kernel or container lets pass.
namespace styled::natnet::testing {

// A group that no other test process uses now.
inline std::string OwnGroup(int index) {
  const int pid = getpid();
  return "239.255." + std::to_string(64 + (pid + index) % 128) + "." +
         std::to_string(1 + pid / 128 % 250);
}

inline bool CanMulticast(const std::string& group) {
  const Descriptor receiver(socket(AF_INET, SOCK_DGRAM, 0));
  const Descriptor sender(socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  inet_pton(AF_INET, group.c_str(), &address.sin_addr);
  in_addr loopback{};
  loopback.s_addr = htonl(INADDR_LOOPBACK);
  const ip_mreqn membership{address.sin_addr, loopback, 0};
  socklen_t size = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  pollfd waiting{receiver.get(), POLLIN, 0};
  return bind(receiver.get(), any, size) == 0 && getsockname(receiver.get(), any, &size) == 0 &&
         setsockopt(receiver.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership,
                    sizeof membership) == 0 &&
         setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof loopback) == 0 &&
         sendto(sender.get(), "x", 1, 0, any, size) == 1 && poll(&waiting, 1, 1000) == 1;
}

}  // namespace styled::natnet::testing
