#include "clients/doctor/interfaces.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "clients/doctor/address.h"

namespace styled::doctor {
namespace {

std::string HostOf(const sockaddr* address) {
  if (address == nullptr) return "";
  sockaddr_storage storage{};
  if (address->sa_family == AF_INET) {
    std::memcpy(&storage, address, sizeof(sockaddr_in));
  } else if (address->sa_family == AF_INET6) {
    std::memcpy(&storage, address, sizeof(sockaddr_in6));
    const auto& v6 = reinterpret_cast<const sockaddr_in6&>(storage);
    if (IN6_IS_ADDR_LINKLOCAL(&v6.sin6_addr)) return "";
  } else {
    return "";
  }
  return FromSocket(storage).host;
}

}  // namespace

std::vector<Interface> ListInterfaces() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owned(list, freeifaddrs);
  std::vector<Interface> out;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    auto found = std::ranges::find(out, entry->ifa_name, &Interface::name);
    if (found == out.end()) {
      Interface fresh;
      fresh.name = entry->ifa_name;
      fresh.index = if_nametoindex(entry->ifa_name);
      fresh.up = (entry->ifa_flags & IFF_UP) != 0;
      fresh.running = (entry->ifa_flags & IFF_RUNNING) != 0;
      fresh.multicast = (entry->ifa_flags & IFF_MULTICAST) != 0;
      fresh.loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0;
      out.push_back(std::move(fresh));
      found = out.end() - 1;
    }
    if (std::string host = HostOf(entry->ifa_addr); !host.empty()) {
      found->addresses.push_back(std::move(host));
    }
    const bool broadcast = (entry->ifa_flags & IFF_BROADCAST) != 0;
    if (std::string host = broadcast ? HostOf(entry->ifa_broadaddr) : ""; !host.empty()) {
      found->broadcasts.push_back(std::move(host));
    }
  }
  return out;
}

const Interface* FindInterface(const std::vector<Interface>& interfaces, std::string_view text) {
  const auto found = std::ranges::find_if(interfaces, [text](const Interface& i) {
    return i.name == text || std::ranges::find(i.addresses, text) != i.addresses.end();
  });
  return found == interfaces.end() ? nullptr : &*found;
}

const Interface* FindInterface(const std::vector<Interface>& interfaces, unsigned index) {
  const auto found = std::ranges::find(interfaces, index, &Interface::index);
  return found == interfaces.end() ? nullptr : &*found;
}

std::string RouteTo(const std::string& host) {
  sockaddr_storage address;
  const socklen_t size = ToSocket({host, 9}, address);
  if (size == 0) return "";
  const int fd = socket(address.ss_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return "";
  std::string out;
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0) {
    socklen_t length = sizeof address;
    getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
    out = FromSocket(address).host;
  }
  close(fd);
  return out;
}

}  // namespace styled::doctor
