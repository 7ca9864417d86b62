#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <string>

#include "daemon/runtime/descriptor.h"
#include "model/base/status.h"

namespace styled::runtime {

// A bound, non-blocking socket. `address` is numeric HOST:PORT; `type` SOCK_DGRAM or SOCK_STREAM.
// Errors name the address and say when another process has the port.
Result<Descriptor> BindSocket(int type, const std::string& address, int receive_buffer_bytes);

// "127.0.0.1:43211" of a bound socket.
std::string BoundAddress(int fd);
// The same of an address that a socket gave; "an unknown address" where it is none.
std::string AddressText(const sockaddr_storage& address, socklen_t size);

}  // namespace styled::runtime
