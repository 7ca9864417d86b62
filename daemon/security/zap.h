#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace styled::security {

// The guarded sockets. Domain() is the ZAP domain of a socket's requests, e.g. "publish".
enum class Door : std::uint8_t { kPublish, kControl };
std::string_view Domain(Door door) noexcept;

// libzmq's question about a connection (rfc.zeromq.org/spec/27). The client has already proved that
// it holds the secret key; nothing else from it has been read.
struct ZapRequest {
  std::string_view id;  // to be repeated in the reply
  Door door = Door::kPublish;
  std::string_view address;  // the client's address, numeric, without port
  std::string key;           // the client's public key, Z85
};

enum class ZapResult : std::uint8_t {
  kOk,
  kFrames,     // not the seven frames of a CURVE request
  kVersion,    // not "1.0"
  kDomain,     // not the domain of a guarded socket
  kMechanism,  // not "CURVE"
  kKey         // not 32 bytes
};

// Parses the frames behind the empty delimiter and assumes nothing about them. Writes `out` on kOk
// only; its views point into `frames`.
ZapResult ParseZap(std::span<const std::string> frames, ZapRequest& out);

}  // namespace styled::security
