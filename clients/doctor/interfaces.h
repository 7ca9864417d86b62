#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace styled::doctor {

// A network interface of this machine, as the kernel reports it.
struct Interface {
  std::string name;
  unsigned index = 0;
  bool up = false;       // administratively enabled
  bool running = false;  // enabled and connected to a network
  bool multicast = false, loopback = false;
  std::vector<std::string> addresses;   // IPv4 and IPv6, without link-local IPv6
  std::vector<std::string> broadcasts;  // IPv4
};

std::vector<Interface> ListInterfaces();

// The interface with that name or address; null if there is none.
const Interface* FindInterface(const std::vector<Interface>& interfaces, std::string_view text);
const Interface* FindInterface(const std::vector<Interface>& interfaces, unsigned index);

// The local address from which datagrams to `host` leave. It identifies the interface on which a
// group is joined if none is configured. "" if there is no route.
std::string RouteTo(const std::string& host);

}  // namespace styled::doctor
