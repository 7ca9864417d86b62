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

// The clients that are allowed, and which client owns which connection of the publisher. libzmq
// asks about a client only when it connects. To stop publishing to a revoked client at once, this
// class cuts its connections; the client may reconnect and is then refused. Requests on the control
// socket are checked one by one. A client is identified by its public key, in Z85. Any thread may
// call; a call holds a lock for a look-up.
class Access {
 public:
  enum class Verdict : std::uint8_t { kAllowed, kUnknownKey, kRole };
  // `client`, if not null, receives the client's entry unless the key is unknown. Subscribing
  // requires any known key, control requires an operator's.
  Verdict Judge(std::string_view key, Door door, keys::Client* client = nullptr) const;

  // Notes that the client with `key` has subscribed over the connection `fd` of this process. If
  // the client was revoked meanwhile, the connection is cut at once. Cheap: for a known connection
  // it costs a look-up and a system call.
  void NoteSubscriber(std::string_view key, int fd);

  struct Change {
    std::vector<keys::Client> allowed, revoked;  // `allowed`: new clients; `revoked`: removed ones.
                                                 // A client whose role changed is in both
    int cut = 0;                                 // number of connections cut
  };
  // Replaces the list of allowed clients and cuts the connections of those that are gone.
  Change Replace(std::vector<keys::Client> clients);

  // Cuts the connections of all clients that are not allowed. A connection that could not be cut
  // for lack of a descriptor is tried again at the next call. Returns the number of connections
  // cut.
  int Sweep();

  std::size_t size() const;

 private:
  // The inode identifies the socket, because a later socket may get the same descriptor number.
  struct Connection {
    ino_t inode = 0;
    std::string key;
  };
  const keys::Client* Find(std::string_view key) const;

  mutable std::mutex mutex_;
  std::vector<keys::Client> clients_;
  std::map<int, Connection> connections_;  // by descriptor, which bounds their number
};

}  // namespace styled::security
