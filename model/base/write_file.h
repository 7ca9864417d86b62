#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>

#include "model/base/descriptor.h"
#include "model/base/status.h"

namespace styled {

// Writes a file as a whole: FILE.new, on the disk, then renamed, so that there is either the old
// content or the new one. On an error, which names the file and the system's reason, the old
// content stays. Blocks.
inline Status WriteFileAtomically(const std::string& file, std::string_view bytes,
                                  mode_t mode = 0640) {
  const std::string fresh = file + ".new";
  const auto refuse = [&file, &fresh] {
    const std::string why = std::strerror(errno);
    unlink(fresh.c_str());
    return Status::Error(file + ": cannot be written: " + why);
  };
  const Descriptor out(open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode));
  if (out.get() < 0) return refuse();
  while (!bytes.empty()) {
    const ssize_t written = write(out.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return refuse();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  if (fsync(out.get()) != 0 || rename(fresh.c_str(), file.c_str()) != 0) return refuse();
  return Status::Ok();
}

}  // namespace styled
