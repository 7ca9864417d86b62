#include "clients/cpp/key_options.h"

#include <CLI/CLI.hpp>

#include "proto/keys/key_folder.h"

namespace styled::client {

void Declare(CLI::App& app, KeyOptions& options) {
  app.add_option("--key", options.key,
                 "file with the client's own pair of keys (stylectl keygen), for a daemon on "
                 "another machine")
      ->envname("STYLED_KEY");
  app.add_option("--server-key", options.server_key,
                 "that daemon's public key, or a file that holds it (its server.pub)")
      ->envname("STYLED_SERVER_KEY");
}

std::string Advice(Obstacle obstacle, Peer peer) {
  const bool control = peer == Peer::kControl;
  const std::string section = control ? "control" : "publish";
  switch (obstacle) {
    case Obstacle::kNone:
      return "";
    case Obstacle::kBadEndpoint:
      return "an endpoint is tcp://HOST:PORT or ipc://PATH, e.g. the daemon's " + section +
             ".address";
    case Obstacle::kNoEntry:
      return "root adds a user to a group: usermod -aG GROUP USER; it takes effect at their next "
             "login "
             "on";
    case Obstacle::kAsksForKeys:
      return "it needs --key and --server-key (STYLED_KEY, STYLED_SERVER_KEY); stylectl keygen "
             "makes the first, server.pub in the daemon's folder of keys is the second";
    case Obstacle::kAsksForNone:
      return "leave out --key and --server-key (STYLED_KEY, STYLED_SERVER_KEY)";
    case Obstacle::kWrongKeys:
      return "--server-key: server.pub in the daemon's folder of keys, or stylectl keys on its "
             "machine, has the right one";
    case Obstacle::kNotLetIn:
      return "on the daemon's machine: stylectl allow NAME 'PUBLICKEY' --role " +
             std::string(control ? "operator; a subscriber's key does not open the control socket"
                                 : "subscriber");
    case Obstacle::kForbidden:
    case Obstacle::kTurnedAway:
      return section + ".ipc_mode and " + section + ".ipc_users in styled.toml say who may connect";
    default:
      return "is styled running, and is its " +
             std::string(control ? "control socket" : "publisher") + " there (" + section +
             ".address in styled.toml)?";
  }
}

Result<std::optional<Curve>> ReadKeys(const KeyOptions& options) {
  if (options.key.empty() && options.server_key.empty()) return std::optional<Curve>();
  if (options.key.empty()) {
    return Status::Error("--server-key: expected also --key FILE (stylectl keygen FILE)");
  }
  if (options.server_key.empty()) {
    return Status::Error("--key: expected also --server-key KEY, the daemon's public key");
  }
  const auto pair = keys::ReadPair(options.key);
  if (!pair.ok()) return Status::Error("--key " + pair.status().message());
  Curve curve{options.server_key, pair.value().public_key, pair.value().secret_key};
  if (keys::IsKey(curve.server_key)) return std::optional(std::move(curve));
  auto server = keys::ReadPublicKey(options.server_key);
  if (!server.ok()) {
    return Status::Error("--server-key " + server.status().message() +
                         "; expected a key, 40 characters of Z85, or a file that holds one");
  }
  curve.server_key = std::move(server.value());
  return std::optional(std::move(curve));
}

}  // namespace styled::client
