#pragma once

#include <string>

#include "model/base/status.h"

namespace styled::client {

// Keys of ZeroMQ's CURVE (rfc.zeromq.org/spec/26), each 40 characters of Z85. They are for a daemon
// that is reached over a network instead of loopback. If the client's key pair is missing,
// Complete() generates one. That suffices for a daemon that admits every client that knows its
// public key, but not for a daemon with a list of clients.
struct Curve {
  std::string server_key;  // the daemon's public key
  std::string public_key;  // the client's key pair: both keys, or neither
  std::string secret_key;
};

// Checks `curve` and generates the key pair if it is missing. The error names the invalid key.
Result<Curve> Complete(const Curve& curve);

}  // namespace styled::client
