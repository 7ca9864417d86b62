#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/base/status.h"
#include "proto/keys/key_file.h"

// A daemon's folder of keys:
//
//   server.key          its own pair; read by the daemon alone, made by it where there is none
//   server.pub          the public one of the two, for clients
//   clients/NAME.key    a client that is let in: public key and role
//
// Every file is written whole or not at all. Start-up and commands only: allocates, blocks.
namespace styled::keys {

inline constexpr std::size_t kMaxClients = 1000;

struct Client {
  std::string name;  // [A-Za-z0-9_-]{1,32}
  std::string key;   // public, Z85
  Role role = Role::kSubscriber;
  friend bool operator==(const Client&, const Client&) = default;
};

struct Clients {
  std::vector<Client> allowed;          // by name; each key once
  std::vector<std::string> complaints;  // files that let nobody in, and why
};

std::string ServerKeyFile(const std::string& folder);
std::string ServerPublicFile(const std::string& folder);
std::string ClientsFolder(const std::string& folder);
bool IsClientName(std::string_view name) noexcept;

// A pair of keys. Refused: a file that others can read (more than 0600; 0640 where root owns it and
// we are not root, as systemd hands over credentials), that somebody else owns, that holds no
// secret key.
Result<KeyFile> ReadPair(const std::string& file);
// The text of a file that holds a token, at most 4096 bytes of it. Refused as ReadPair refuses: a
// file that others can read, or that somebody else owns.
Result<std::string> ReadTokenFile(const std::string& file);
// A file's public key, whatever else it holds.
Result<std::string> ReadPublicKey(const std::string& file);
// Writes a pair, 0600. Refuses to replace a file.
Status WritePair(const std::string& file, const KeyFile& pair);

// The pair in `folder`, which is made with the pair in it where they are missing (`made`). Refuses
// a folder, or its clients/, that others may write to: they could let themselves in.
Result<KeyFile> ServerPair(const std::string& folder, bool& made);

// Who is let in. A file that is wrong, that others may write to or that repeats another's key is a
// complaint and lets nobody in. That there is no clients/ is no error: nobody. Error: it cannot be
// listed, or a file cannot be read for want of descriptors or memory; nothing is known then.
Result<Clients> ReadClients(const std::string& folder);

// Lets `client` in, in the place of a client of its name. Refuses a name or key that is none, a key
// that another client has, and a folder that is not there.
Status Allow(const std::string& folder, const Client& client);
// Refuses a name that is not let in.
Status Revoke(const std::string& folder, const std::string& name);

}  // namespace styled::keys
