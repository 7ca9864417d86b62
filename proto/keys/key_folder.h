#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "proto/keys/key_file.h"

// A daemon's folder of keys:
//
//   server.key          its own pair; read by the daemon only, created by it if missing
//   server.pub          the public key of that pair, for clients
//   clients/NAME.key    an allowed client: public key and role
//
// Every file is written completely or not at all. Start-up and commands only: allocates, blocks.
namespace styled::keys {

inline constexpr std::size_t kMaxClients = 1000;

struct Client {
  std::string name;  // [A-Za-z0-9_-]{1,32}
  std::string key;   // public key, Z85
  Role role = Role::kSubscriber;
  friend bool operator==(const Client&, const Client&) = default;
};

struct Clients {
  std::vector<Client> allowed;          // sorted by name; each key once
  std::vector<std::string> complaints;  // files that allow no client, and why
};

std::string ServerKeyFile(const std::string& folder);
std::string ServerPublicFile(const std::string& folder);
std::string ClientsFolder(const std::string& folder);
bool IsClientName(std::string_view name) noexcept;

// Reads a pair of keys. Refuses a file that others can read (more than 0600; 0640 is accepted if
// root owns it and the process is not root, because systemd passes credentials in this way), that
// another user owns, or that holds no secret key.
Result<KeyFile> ReadPair(const std::string& file);
// Reads a file that holds a token, at most 4096 bytes. Refuses, like ReadPair, a file that others
// can read or that another user owns.
Result<std::string> ReadTokenFile(const std::string& file);
// Reads the public key of a file, whatever else the file holds.
Result<std::string> ReadPublicKey(const std::string& file);
// Writes a pair with mode 0600. Refuses to replace a file.
Status WritePair(const std::string& file, const KeyFile& pair);

// Reads the pair in `folder`. Creates the folder and the pair if they are missing (sets `made`).
// Refuses a folder, or a folder clients/ in it, that others may write to: they could allow
// themselves.
Result<KeyFile> ServerPair(const std::string& folder, bool& made);

// Reads the allowed clients. A file that is invalid, that others may write to or that repeats
// another client's key allows no client and gives a complaint. A missing clients/ means no clients.
// Error: the folder cannot be listed, or a file cannot be read for lack of descriptors or memory,
// so that nothing is known about it.
Result<Clients> ReadClients(const std::string& folder);

// Allows `client`, and replaces a client of the same name. Refuses an invalid name or key, a key of
// another client, and a missing folder.
Status Allow(const std::string& folder, const Client& client);
// Removes a client. Refuses the name of a client that is not allowed.
Status Revoke(const std::string& folder, const std::string& name);

}  // namespace styled::keys
