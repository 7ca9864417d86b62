#include "daemon/security/access.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>

#include "daemon/runtime/descriptor.h"

namespace styled::security {
namespace {

// 0: no socket.
ino_t InodeOf(int fd) {
  struct stat about {};
  return fstat(fd, &about) == 0 && S_ISSOCK(about.st_mode) ? about.st_ino : 0;
}

// libzmq owns the descriptor and may close it at any time: what is shut down is held by one of our
// own, after a look at what it is. libzmq finds the connection ended by the peer.
bool Cut(int fd, ino_t inode) {
  const runtime::Descriptor held(fcntl(fd, F_DUPFD_CLOEXEC, 0));
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
  const std::lock_guard lock(mutex_);
  Connection& connection = connections_[fd];
  if (connection.inode != inode) connection = {inode, std::string(key)};
  if (Find(key) == nullptr && Cut(fd, inode)) connections_.erase(fd);
}

Access::Change Access::Replace(std::vector<keys::Client> clients) {
  const std::lock_guard lock(mutex_);
  Change change;
  for (const auto& client : clients) {
    if (!Contains(clients_, client)) change.allowed.push_back(client);
  }
  for (const auto& client : clients_) {
    if (!Contains(clients, client)) change.revoked.push_back(client);
  }
  clients_ = std::move(clients);
  change.cut = CutUnknown();
  return change;
}

int Access::Sweep() {
  const std::lock_guard lock(mutex_);
  return CutUnknown();
}

int Access::CutUnknown() {
  int cut = 0;
  for (auto entry = connections_.begin(); entry != connections_.end();) {
    const auto& [fd, connection] = *entry;
    const bool gone = InodeOf(fd) != connection.inode;
    const bool ended = !gone && Find(connection.key) == nullptr && Cut(fd, connection.inode);
    cut += ended ? 1 : 0;
    entry = gone || ended ? connections_.erase(entry) : std::next(entry);
  }
  return cut;
}

std::size_t Access::size() const {
  const std::lock_guard lock(mutex_);
  return clients_.size();
}

}  // namespace styled::security
