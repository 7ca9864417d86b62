#include "daemon/runtime/zmq_socket.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "proto/ipc/path.h"

namespace styled::runtime {

// The lock is a file beside the socket, because libzmq removes the socket's file and makes a new
// one.
Status ZmqSocket::LockPath(const std::string& path, const std::string& place) {
  const std::string file = path + ".lock";
  lock_ = Descriptor(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (lock_.get() < 0) {
    return Status::Error(place + "cannot write its lock file " + file + ": " +
                         std::strerror(errno));
  }
  if (flock(lock_.get(), LOCK_EX | LOCK_NB) == 0) return Status::Ok();
  return Status::Error(place + "in use (another styled?)");
}

// The umask gives the file its final mode at creation, so that no other user can connect before a
// chmod.
bool ZmqSocket::BindIpc(const std::string& address, const IpcAccess& ipc) {
  for (const uid_t user : ipc.users) {
    if (zmq_setsockopt(socket_, ZMQ_IPC_FILTER_UID, &user, sizeof user) != 0) return false;
  }
  const mode_t before = umask(static_cast<mode_t>(0777U & ~ipc.mode));
  const bool bound = zmq_bind(socket_, address.c_str()) == 0;
  const int error = errno;
  umask(before);
  errno = error;
  return bound;
}

Status ZmqSocket::Bind(const std::string& address, const std::string& key, std::string& endpoint,
                       const IpcAccess& ipc) {
  const std::string place = key + ": " + address + ": ";
  if (socket_ == nullptr) return Status::Error(place + zmq_strerror(zmq_errno()));
  std::string wanted = address;
  bool done = false;
  if (address.starts_with("ipc://")) {
    const std::string path = address.substr(6);
    // CheckKind runs before the lock file is created beside the path. CheckFree runs once the lock
    // guarantees that no other daemon uses the path.
    if (Status status = ipc::CheckKind(path); !status.ok()) {
      return Status::Error(place + status.message());
    }
    if (Status status = LockPath(path, place); !status.ok()) return status;
    if (Status status = ipc::CheckFree(path); !status.ok()) {
      return Status::Error(place + status.message());
    }
    done = BindIpc(address, ipc);
  } else {
    if (wanted.ends_with(":0")) wanted.back() = '*';
    Set(ZMQ_IPV6, wanted.find('[') != std::string::npos ? 1 : 0);
    done = zmq_bind(socket_, wanted.c_str()) == 0;
  }
  if (!done) {
    const int error = zmq_errno();
    return Status::Error(place +
                         (error == EADDRINUSE ? "in use (another styled?)" : zmq_strerror(error)));
  }
  std::array<char, 256> bound{};
  std::size_t size = bound.size();
  zmq_getsockopt(socket_, ZMQ_LAST_ENDPOINT, bound.data(), &size);
  endpoint = bound.data();
  return Status::Ok();
}

}  // namespace styled::runtime
