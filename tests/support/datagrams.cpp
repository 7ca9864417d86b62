#include "tests/support/datagrams.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>

namespace styled::support {

Datagrams::Datagrams()
    : path_(folder_ / "socket"), fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (path_.size() >= sizeof name.sun_path) std::abort();
  std::memcpy(name.sun_path, path_.data(), path_.size());
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0) std::abort();
}

Datagrams::~Datagrams() { close(fd_); }

std::optional<std::string> Datagrams::Next(double seconds) {
  pollfd waiting{fd_, POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(seconds * 1000)) <= 0) return std::nullopt;
  std::array<char, 65536> bytes;
  const ssize_t size = recv(fd_, bytes.data(), bytes.size(), 0);
  return std::string(bytes.data(), static_cast<std::size_t>(size));
}

std::optional<std::string> Datagrams::Await(const std::string& text) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::seconds(20);
  while (Clock::now() < end) {
    auto next = Next(1);
    if (next && next->find(text) != std::string::npos) return next;
  }
  return std::nullopt;
}

}  // namespace styled::support
