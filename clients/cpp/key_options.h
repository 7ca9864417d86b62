#pragma once

#include <optional>
#include <string>

#include "clients/cpp/curve.h"
#include "clients/cpp/reach.h"
#include "model/base/status.h"

namespace CLI {  // NOLINT(readability-identifier-naming): a library's
class App;
}

namespace styled::client {

// The two command-line options with which the project's programs reach a daemon that requires keys.
struct KeyOptions {
  std::string key;  // file with the client's key pair, as `stylectl keygen` writes it; "" = none
  std::string server_key;  // the daemon's public key, or a file that contains it; "" = none
};

// Adds --key and --server-key. Defaults: STYLED_KEY and STYLED_SERVER_KEY of the environment.
void Declare(CLI::App& app, KeyOptions& options);

// The user's remedy for `obstacle`: one sentence without a full stop, or a question. "" for kNone.
std::string Advice(Obstacle obstacle, Peer peer);

// Empty if neither option is given. Errors name the option and the file.
Result<std::optional<Curve>> ReadKeys(const KeyOptions& options);

}  // namespace styled::client
