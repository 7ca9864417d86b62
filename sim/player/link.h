#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "model/base/status.h"

namespace styled::player {

// Where datagrams go. Calls may block. One thread.
class Link {
 public:
  virtual ~Link() = default;
  // Sends one whole datagram, or one record of a stream.
  virtual Status Send(std::span<const std::byte> datagram) = 0;
  // One datagram that came back, if there is one: its size, else 0. Never blocks.
  virtual std::size_t Receive(std::span<std::byte> /*datagram*/) { return 0; }
  // How many datagrams came back as refused: nobody listens at that port. 0 where it is not known.
  virtual std::uint64_t refused() { return 0; }
  // Sends to whom the last one received came from.
  virtual Status Answer(std::span<const std::byte> datagram) { return Send(datagram); }
};

// "udp://HOST:PORT" or "tcp://HOST:PORT" (IPv6 hosts in brackets). UDP never fails for want of a
// receiver: where the other machine says that nobody listens, Link::refused() counts it and sending
// goes on. TCP is tried again for `start_wait_ms` while nobody listens; errors name the address
// and the reason.
Result<std::unique_ptr<Link>> Connect(const std::string& url, double start_wait_ms);

// A server's socket, bound to "udp://HOST:PORT" (port 0: any): Send() goes to everyone who was
// heard within the last 5 s. `bound`, where given, is set to the real address.
Result<std::unique_ptr<Link>> Listen(const std::string& url, std::string* bound = nullptr);

// Whether Connect() can read the address; with port 0 from `lowest_port` 0 on, as Listen() does.
Status CheckAddress(const std::string& url, int lowest_port = 1);

// True for an address that Connect() would send to by TCP.
bool IsStream(const std::string& url);

}  // namespace styled::player
