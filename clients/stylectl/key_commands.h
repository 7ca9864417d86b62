#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "model/base/status.h"

namespace styled::stylectl {

// Arguments of keygen, allow, revoke and keys.
struct KeyArguments {
  std::string folder = "/var/lib/styled/keys";  // the daemon's security.keys
  std::string file;                             // keygen
  std::string name, key, role = "subscriber";   // allow; `key` may be a file that contains the key
};

// The result of a command, as text for people and as JSON.
struct KeyReport {
  std::string text;
  nlohmann::json object;
};

// These work on local files and need no running daemon. A running daemon with the same folder
// applies changes at once. Errors name the file and what was expected.
Result<KeyReport> Keygen(const KeyArguments& arguments);
Result<KeyReport> AllowKey(const KeyArguments& arguments);
Result<KeyReport> RevokeKey(const KeyArguments& arguments);
Result<KeyReport> ListKeys(const KeyArguments& arguments);

}  // namespace styled::stylectl
