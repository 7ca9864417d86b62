#include "daemon/security/access.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <utility>

#include "model/base/descriptor.h"

namespace styled::security {
namespace {

// Returns 0 when `fd` is not a socket.
ino_t InodeOf(int fd) {
  struct stat about {};
  return fstat(fd, &about) == 0 && S_ISSOCK(about.st_mode) ? about.st_ino : 0;
}

// libzmq owns `fd` and may close it at any time, after which the number may belong to another
// socket. The duplicate pins whatever `fd` is now; it is shut down only if its inode is the
// expected one. libzmq then sees the connection ended by the peer.
bool Cut(int fd, ino_t inode) {
  const Descriptor held(fcntl(fd, F_DUPFD_CLOEXEC, 0));
  return held.get() >= 0 && InodeOf(held.get()) == inode && shutdown(held.get(), SHUT_RDWR) == 0;
}

bool Contains(const std::vector<keys::Client>& clients, const keys::Client& client) {
  return std::find(clients.begin(), clients.end(), client) != clients.end();
}

}  // namespace

const keys::Client* Access::Find(std::string_view key) const {
  const auto found = std::find_if(clients_.begin(), clients_.end(),
                                  [key](const keys::Client& client) { return client.key == key; });
  return found == clients_.end() ? nullptr : &*found;
}

Access::Verdict Access::Judge(std::string_view key, Door door, keys::Client* client) const {
  const std::lock_guard lock(mutex_);
  const keys::Client* const found = Find(key);
  if (found == nullptr) return Verdict::kUnknownKey;
  if (client != nullptr) *client = *found;
  const bool enough = door == Door::kPublish || found->role == keys::Role::kOperator;
  return enough ? Verdict::kAllowed : Verdict::kRole;
}

void Access::NoteSubscriber(std::string_view key, int fd) {
  const ino_t inode = InodeOf(fd);
  if (inode == 0) return;
  {
    const std::lock_guard lock(mutex_);
    Connection& connection = connections_[fd];
    if (connection.inode == inode) return;
    connection = {inode, std::string(key)};
    if (Find(key) != nullptr) return;
  }
  Sweep();
}

Access::Change Access::Replace(std::vector<keys::Client> clients) {
  Change change;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& client : clients) {
      if (!Contains(clients_, client)) change.allowed.push_back(client);
    }
    for (const auto& client : clients_) {
      if (!Contains(clients, client)) change.revoked.push_back(client);
    }
    clients_ = std::move(clients);
  }
  change.cut = Sweep();
  return change;
}

// The slow system calls run without the lock, because the pipeline may wait for it.
int Access::Sweep() {
  std::vector<std::pair<int, ino_t>> strangers;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [fd, connection] : connections_) {
      if (Find(connection.key) == nullptr) strangers.emplace_back(fd, connection.inode);
    }
  }
  int cut = 0;
  for (const auto& [fd, inode] : strangers) {
    const bool ended = Cut(fd, inode);
    cut += ended ? 1 : 0;
    if (!ended && InodeOf(fd) == inode) continue;  // still open: tried again at the next call
    const std::lock_guard lock(mutex_);
    const auto found = connections_.find(fd);
    if (found != connections_.end() && found->second.inode == inode) connections_.erase(found);
  }
  return cut;
}

std::size_t Access::size() const {
  const std::lock_guard lock(mutex_);
  return clients_.size();
}

}  // namespace styled::security
