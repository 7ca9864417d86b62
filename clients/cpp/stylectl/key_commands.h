#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "model/base/status.h"

namespace styled::stylectl {

// What keygen, allow, revoke and keys are told.
struct KeyArguments {
  std::string folder = "/var/lib/styled/keys";  // the daemon's security.keys
  std::string file;                             // of keygen
  std::string name, key, role = "subscriber";   // of allow; `key` may be a file that holds it
};

// What such a command says: to people, and as JSON.
struct KeyReport {
  std::string text;
  nlohmann::json object;
};

// They work on files, of this machine; no daemon need run. One that runs and has this folder obeys
// at once. Errors name the file and what was expected.
Result<KeyReport> Keygen(const KeyArguments& arguments);
Result<KeyReport> AllowKey(const KeyArguments& arguments);
Result<KeyReport> RevokeKey(const KeyArguments& arguments);
Result<KeyReport> ListKeys(const KeyArguments& arguments);

}  // namespace styled::stylectl
