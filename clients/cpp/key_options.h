#pragma once

#include <optional>
#include <string>

#include "clients/cpp/curve.h"
#include "clients/cpp/reach.h"
#include "model/base/status.h"

namespace CLI {
class App;
}

namespace styled::client {

// The two options by which our programs reach a daemon that asks for keys.
struct KeyOptions {
  std::string key;         // file of the own pair, as `stylectl keygen` makes it; "" = none
  std::string server_key;  // the daemon's public key, or a file that holds it; "" = none
};

// --key, --server-key; or STYLED_KEY, STYLED_SERVER_KEY of the environment.
void Declare(CLI::App& app, KeyOptions& options);

// What a user of our programs can do about it; one sentence without a full stop, or a question.
// "" for kNone.
std::string Advice(Obstacle obstacle, Peer peer);

// Nothing where neither is given. Errors name the option, and the file.
Result<std::optional<Curve>> ReadKeys(const KeyOptions& options);

}  // namespace styled::client
