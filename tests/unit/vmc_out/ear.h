#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace styled::stylevmc {

// A UDP socket on IPv4 loopback, on a port of the kernel's choice or on `port`.
class Ear {
 public:
  explicit Ear(const std::string& port = "0") : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port)));
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address_;
    (void)bind(fd_, reinterpret_cast<sockaddr*>(&address_), size);
    (void)getsockname(fd_, reinterpret_cast<sockaddr*>(&address_), &size);
  }
  ~Ear() { close(fd_); }
  Ear(const Ear&) = delete;
  Ear& operator=(const Ear&) = delete;

  std::string port() const { return std::to_string(ntohs(address_.sin_port)); }
  std::string address() const { return "127.0.0.1:" + port(); }

  // The next datagram; empty where none comes within `wait_ms`.
  std::vector<std::byte> Receive(int wait_ms = 2000) const {
    pollfd item{fd_, POLLIN, 0};
    if (poll(&item, 1, wait_ms) <= 0) return {};
    std::vector<std::byte> datagram(65536);
    const ssize_t size = recv(fd_, datagram.data(), datagram.size(), 0);
    datagram.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    return datagram;
  }

 private:
  int fd_;
  sockaddr_in address_{};
};

}  // namespace styled::stylevmc
