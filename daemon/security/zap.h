#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace styled::security {

// The sockets that ask; the domain of their requests.
enum class Door : std::uint8_t { kPublish, kControl };
std::string_view Domain(Door door) noexcept;  // "publish"

// What libzmq asks about a connection (rfc.zeromq.org/spec/27) whose client has proved that the
// secret key is his, before anything else of him is read.
struct ZapRequest {
  std::string_view id;  // to be repeated in the reply
  Door door = Door::kPublish;
  std::string_view address;  // the peer's, numeric, without port
  std::string key;           // his public key, Z85
};

enum class ZapResult : std::uint8_t {
  kOk,
  kFrames,     // not the seven of CURVE
  kVersion,    // not "1.0"
  kDomain,     // of no socket of ours
  kMechanism,  // not "CURVE"
  kKey         // not 32 bytes
};

// Reads the frames behind the empty delimiter. Nothing is assumed of them; `out` is written on kOk
// only, and points into `frames`.
ZapResult ParseZap(std::span<const std::string> frames, ZapRequest& out);

}  // namespace styled::security
