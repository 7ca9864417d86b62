#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "model/base/status.h"

// Keys of ZeroMQ's CURVE (rfc.zeromq.org/spec/26) in files, in the form that other ZeroMQ programs
// write (czmq's certificates, pyzmq's zmq.auth):
//
//   metadata
//       role = "subscriber"
//   curve
//       public-key = "..."
//       secret-key = "..."
//
// Lines that begin with # are comments. `role` is an extension and used only in the files of
// allowed clients.
namespace styled::keys {

inline constexpr std::size_t kKeyCharacters = 40;  // of Z85, for 32 bytes

// The permissions of a client's key at the daemon.
enum class Role : std::uint8_t {
  kSubscriber,  // frames only
  kOperator     // frames and the control socket
};
std::string_view Name(Role role) noexcept;
std::optional<Role> ParseRole(std::string_view text) noexcept;

struct KeyFile {
  std::string public_key;    // Z85
  std::string secret_key;    // Z85; "" = the file holds the public key only
  std::optional<Role> role;  // empty if the file states none
};

// Whether `text` is a key: 40 characters of Z85.
bool IsKey(std::string_view text);
// The Z85 text of a key of 32 bytes, as on the wire; "" for another size.
std::string ToText(std::string_view bytes);

// Parses the text of a key file. The text may be hostile. Errors name the line and what was
// expected. Rules: a section `curve` with one public key; a secret key must belong to the public
// one; a role must be a known one.
Result<KeyFile> Parse(std::string_view text);
// Formats the text so that Parse reads it back.
std::string Format(const KeyFile& file);

// Makes a new pair whose public key does not begin with "-".
Result<KeyFile> MakePair();

}  // namespace styled::keys
