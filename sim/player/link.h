#pragma once

#include <cstddef>
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
};

// "udp://HOST:PORT" or "tcp://HOST:PORT" (IPv6 hosts in brackets). UDP never fails for want of a
// receiver. TCP is tried again for `start_wait_ms` while nobody listens; errors name the address
// and the reason.
Result<std::unique_ptr<Link>> Connect(const std::string& url, double start_wait_ms);

// True for an address that Connect() would send to by TCP.
bool IsStream(const std::string& url);

}  // namespace styled::player
