#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <string>

#include "model/base/status.h"

namespace styled {

// Reads a whole file of at most `max_bytes`: a configuration, or another file whose path a running
// daemon receives. The call always ends: it does not wait for a pipe, does not open a device, and
// stops at the limit if the file grows while it is read. Errors name the file, its kind and what
// was expected. Blocks on the disk; allocates; any thread.
inline Result<std::string> ReadFile(const std::string& file, std::size_t max_bytes) {
  const auto refuse = [&file](const std::string& why) { return Status::Error(file + ": " + why); };
  const auto not_a_file = [&refuse](mode_t mode) {
    const char* const kind = S_ISDIR(mode)    ? "a folder"
                             : S_ISFIFO(mode) ? "a pipe"
                             : S_ISSOCK(mode) ? "a socket"
                                              : "a device";
    return refuse(std::string("is ") + kind + "; expected a regular file");
  };
  // Checked before open(), because opening a device may already have an effect.
  struct stat about {};
  if (stat(file.c_str(), &about) != 0) return refuse(std::strerror(errno));
  if (!S_ISREG(about.st_mode)) return not_a_file(about.st_mode);
  const int fd = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (fd < 0) return refuse(std::strerror(errno));
  const struct Closer {
    ~Closer() { close(fd); }
    int fd;
  } closer{fd};
  // Checked again, because another file may have replaced it since stat().
  if (fstat(fd, &about) != 0) return refuse(std::strerror(errno));
  if (!S_ISREG(about.st_mode)) return not_a_file(about.st_mode);

  const auto too_large = [&] {
    constexpr std::size_t kMiB = 1 << 20;
    const bool whole = max_bytes % kMiB == 0;
    return refuse("larger than the limit of " +
                  std::to_string(whole ? max_bytes / kMiB : max_bytes) +
                  (whole ? " MiB" : " bytes"));
  };
  if (static_cast<std::size_t>(about.st_size) > max_bytes) return too_large();
  constexpr std::size_t kChunk = 64 << 10;  // bytes per read()
  std::string text;
  text.reserve(static_cast<std::size_t>(about.st_size) + kChunk);
  while (true) {
    const std::size_t size = text.size();
    text.resize(size + kChunk);
    const ssize_t got = read(fd, text.data() + size, kChunk);
    const int error = errno;
    text.resize(size + static_cast<std::size_t>(got > 0 ? got : 0));
    if (got < 0 && error == EINTR) continue;
    if (got < 0) return refuse(std::strerror(error));
    if (got == 0) return text;
    if (text.size() > max_bytes) return too_large();
  }
}

}  // namespace styled
