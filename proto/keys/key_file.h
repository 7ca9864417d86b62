#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "model/base/status.h"

// Keys of ZeroMQ's CURVE (rfc.zeromq.org/spec/26) in files, as other programs of ZeroMQ write them
// (czmq's certificates, pyzmq's zmq.auth):
//
//   metadata
//       role = "subscriber"
//   curve
//       public-key = "..."
//       secret-key = "..."
//
// Lines that begin with # are remarks. `role` is ours, and only in files that let a client in.
namespace styled::keys {

inline constexpr std::size_t kKeyCharacters = 40;  // of Z85, for 32 bytes

// What a client's key opens at the daemon.
enum class Role : std::uint8_t {
  kSubscriber,  // frames, nothing else
  kOperator     // frames and the control socket
};
std::string_view Name(Role role) noexcept;
std::optional<Role> ParseRole(std::string_view text) noexcept;

struct KeyFile {
  std::string public_key;    // Z85
  std::string secret_key;    // Z85; "" = the public one alone
  std::optional<Role> role;  // nothing where the file does not say
};

// Whether `text` is a key: 40 characters of Z85.
bool IsKey(std::string_view text);
// The Z85 of a key as it is on the wire, 32 bytes.
std::string ToText(std::string_view bytes);

// Reads a file's text. Errors name the line and what was expected. Nothing is assumed of `text`.
// Rules: a section `curve` with one public key; a secret key must be the public one's; a role must
// be one that we know.
Result<KeyFile> Parse(std::string_view text);
// What Parse reads.
std::string Format(const KeyFile& file);

Result<KeyFile> MakePair();

}  // namespace styled::keys
