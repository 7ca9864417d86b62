#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/security/zap.h"
#include "proto/keys/key_folder.h"

namespace styled::security {

// Who is let in, and whose connection of the publisher is whose. libzmq asks about a client when he
// connects and never again; so that a client who is revoked hears nothing more, his connections are
// cut here (he may come again, and is refused then). Requests on the control socket are judged one
// by one. Clients are known by their public keys, in Z85. Any thread; holds a lock for a look-up.
class Access {
 public:
  enum class Verdict : std::uint8_t { kAllowed, kUnknownKey, kRole };
  // `client`, if not null, receives who it is, unless the key is unknown.
  Verdict Judge(std::string_view key, Door door, keys::Client* client = nullptr) const;

  // The client behind `key` has subscribed over the connection `fd` of this process. One who was
  // revoked meanwhile is cut at once. Cheap: a subscription of a known connection is a look-up and
  // two system calls.
  void NoteSubscriber(std::string_view key, int fd);

  struct Change {
    std::vector<keys::Client> allowed, revoked;  // new ones, those that are gone; or in a new role
    int cut = 0;                                 // connections
  };
  // From here on `clients` and nobody else.
  Change Replace(std::vector<keys::Client> clients);

  // Tries again what could not be cut for want of a descriptor, and forgets connections that ended.
  // Now and then; returns how many were cut.
  int Sweep();

  std::size_t size() const;

 private:
  // A socket is known by more than its number, which the next one may get.
  struct Connection {
    ino_t inode = 0;
    std::string key;
  };
  const keys::Client* Find(std::string_view key) const;
  int CutUnknown();

  mutable std::mutex mutex_;
  std::vector<keys::Client> clients_;
  std::map<int, Connection> connections_;  // by descriptor: as many as there can be of those
};

}  // namespace styled::security
