#pragma once

#include <optional>
#include <string>

#include "model/base/status.h"

namespace styled::client {

// Keys of ZeroMQ's CURVE (rfc.zeromq.org/spec/26), for a daemon that is reached over a network and
// not over loopback; each of 40 characters of Z85. Without an own pair a new one is made: enough
// for a daemon that lets in everybody who knows its key, not for one that has a list of clients.
struct Curve {
  std::string server_key;  // the daemon's public key
  std::string public_key;  // the own pair: both, or neither
  std::string secret_key;
};

// Checks `curve` and makes the missing pair. The error names the key that is wrong.
Result<Curve> Complete(const Curve& curve);

}  // namespace styled::client
