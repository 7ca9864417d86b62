#include "daemon/runtime/notify.h"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "model/base/text.h"

namespace styled::runtime {
namespace {

// Text after a line break would be another message to systemd. systemd refuses a message that is
// too long as a whole, including its READY=1.
std::string OneLine(std::string_view text) {
  constexpr std::size_t kLongest = 1000;  // bytes; more than `systemctl status` shows
  std::string line(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return Printable(line, kLongest);
}

}  // namespace

Notifier::Notifier(const std::string& address) : address_(address) {
  const bool known = !address.empty() && (address[0] == '/' || address[0] == '@');
  if (!known || address.size() >= sizeof(sockaddr_un::sun_path)) return;
  socket_ = Descriptor(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const timeval longest{1, 0};
  setsockopt(socket_.get(), SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof longest);
}

Notifier Notifier::FromEnvironment() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  return Notifier(address == nullptr ? "" : address);
}

void Notifier::Ready(std::string_view text) { Send("READY=1\nSTATUS=" + OneLine(text)); }

void Notifier::Reloading(std::int64_t now_ns) {
  Send("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(now_ns / 1000) + "\nSTATUS=reloading");
}

void Notifier::Stopping() { Send("STOPPING=1\nSTATUS=stopping"); }

void Notifier::SetStatus(std::string_view text) { Send("STATUS=" + OneLine(text), MSG_DONTWAIT); }

void Notifier::Alive() { Send("WATCHDOG=1", MSG_DONTWAIT); }

void Notifier::Send(const std::string& message, int flags) {
  if (socket_.get() < 0) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  if (to.sun_path[0] == '@') to.sun_path[0] = '\0';
  // The length excludes any terminating zero: an abstract name ends at its length, and a path of
  // that length is accepted, too.
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  [[maybe_unused]] const auto sent =
      sendto(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL | flags,
             reinterpret_cast<const sockaddr*>(&to), length);
}

}  // namespace styled::runtime
