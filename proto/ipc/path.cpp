#include "proto/ipc/path.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace styled::ipc {
namespace {

// Whether the path names an abstract socket of Linux, which has no file.
bool IsAbstract(const std::string& path) { return path.starts_with('@'); }

// Connects to the socket. Returns 0, or the errno of the failure.
int Connect(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return ENAMETOOLONG;
  std::memcpy(address.sun_path, path.data(), path.size());
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return errno;
  const int failed = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int error = failed == 0 ? 0 : errno;
  close(fd);
  return error;
}

}  // namespace

Status CheckKind(const std::string& path) {
  if (IsAbstract(path)) return Status::Ok();
  struct stat about {};
  if (lstat(path.c_str(), &about) != 0) {
    return errno == ENOENT ? Status::Ok() : Status::Error(std::strerror(errno));
  }
  if (S_ISSOCK(about.st_mode)) return Status::Ok();
  const char* const found = S_ISREG(about.st_mode)   ? "an ordinary file"
                            : S_ISDIR(about.st_mode) ? "a folder"
                            : S_ISLNK(about.st_mode) ? "a symbolic link"
                                                     : "a pipe or a device";
  return Status::Error(std::string("there is ") + found +
                       "; expected a free path, or a socket that is no longer in use");
}

Status CheckFree(const std::string& path) {
  if (Status status = CheckKind(path); !status.ok()) return status;
  if (IsAbstract(path)) return Status::Ok();
  switch (const int error = Connect(path)) {
    case ENOENT:        // nothing is there
    case ECONNREFUSED:  // no program listens any more
      return Status::Ok();
    case 0:
    case EAGAIN:      // its queue of connections is full
    case EPROTOTYPE:  // a datagram socket
      return Status::Error("in use by another program; expected a free path");
    default:
      return Status::Error(std::strerror(error));
  }
}

}  // namespace styled::ipc
