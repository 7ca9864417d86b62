#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <string>

#include "model/base/descriptor.h"
#include "model/base/status.h"

namespace styled::runtime {

// Opens and binds a non-blocking socket. `address` is a numeric HOST:PORT; `type` is SOCK_DGRAM or
// SOCK_STREAM. Errors name the address and say when another process holds the port.
Result<Descriptor> BindSocket(int type, const std::string& address, int receive_buffer_bytes);

// The local address of a bound socket, e.g. "127.0.0.1:43211".
std::string BoundAddress(int fd);
// The same text for an address returned by a socket call; "an unknown address" if it is not one.
std::string AddressText(const sockaddr_storage& address, socklen_t size);

}  // namespace styled::runtime
