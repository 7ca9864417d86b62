#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace styled::doctor {

// A network interface of this machine, as the kernel has it.
struct Interface {
  std::string name;
  unsigned index = 0;
  bool up = false;       // switched on
  bool running = false;  // and a cable or a wireless network on it
  bool multicast = false, loopback = false;
  std::vector<std::string> addresses;   // IPv4 and IPv6; without link-local IPv6
  std::vector<std::string> broadcasts;  // IPv4
};

std::vector<Interface> ListInterfaces();

// The interface by that name or with that address; null where there is none.
const Interface* FindInterface(const std::vector<Interface>& interfaces, std::string_view text);
const Interface* FindInterface(const std::vector<Interface>& interfaces, unsigned index);

// The address of this machine that datagrams to `host` would leave from, so the interface that a
// group is joined on where none is named; "" where there is no route.
std::string RouteTo(const std::string& host);

}  // namespace styled::doctor
