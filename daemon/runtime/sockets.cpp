#include "daemon/runtime/sockets.h"

#include <arpa/inet.h>
#include <netdb.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "daemon/runtime/host_port.h"

namespace styled::runtime {

Result<Descriptor> BindSocket(int type, const std::string& address, int receive_buffer_bytes) {
  const auto parsed = ParseHostPort(address);
  if (!parsed.ok()) return parsed.status();
  const char* const protocol = type == SOCK_DGRAM ? "udp " : "tcp ";
  addrinfo hints{};
  hints.ai_socktype = type;
  hints.ai_flags = AI_NUMERICHOST | AI_PASSIVE;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(parsed.value().host.c_str(),
                                std::to_string(parsed.value().port).c_str(), &hints, &found);
  if (error != 0) {
    return Status::Error(protocol + address + ": " + gai_strerror(error) +
                         "; expected a numeric address");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owned(found, freeaddrinfo);
  Descriptor socket_fd(socket(found->ai_family, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const auto refuse = [&] {
    const std::string why = errno == EADDRINUSE ? "in use (another styled?)" : std::strerror(errno);
    return Status::Error(protocol + address + ": " + why);
  };
  if (socket_fd.get() < 0) return refuse();
  const int one = 1;
  if (type == SOCK_STREAM) {
    setsockopt(socket_fd.get(), SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
  }
  // SO_RCVBUFFORCE exceeds the system's limit but needs privileges; SO_RCVBUF stays within the
  // limit.
  if (setsockopt(socket_fd.get(), SOL_SOCKET, SO_RCVBUFFORCE, &receive_buffer_bytes,
                 sizeof receive_buffer_bytes) != 0) {
    setsockopt(socket_fd.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes,
               sizeof receive_buffer_bytes);
  }
  if (bind(socket_fd.get(), found->ai_addr, found->ai_addrlen) != 0) return refuse();
  return socket_fd;
}

std::string BoundAddress(int fd) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return AddressText(address, size);
}

std::string AddressText(const sockaddr_storage& address, socklen_t size) {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  const int error =
      getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host.data(), host.size(),
                  port.data(), port.size(), NI_NUMERICHOST | NI_NUMERICSERV);
  if (error != 0) return "an unknown address";
  const std::string name = host.data();
  return (address.ss_family == AF_INET6 ? "[" + name + "]" : name) + ":" + port.data();
}

}  // namespace styled::runtime
