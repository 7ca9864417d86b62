#include "model/clip/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace styled::clip {

InputFile::InputFile(int fd, std::size_t size, std::string name, const char* expected)
    : fd_(fd), size_(size), name_(std::move(name)), expected_(expected) {}

InputFile::InputFile(InputFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      size_(other.size_),
      name_(std::move(other.name_)),
      expected_(other.expected_) {}

InputFile::~InputFile() {
  if (fd_ >= 0) close(fd_);
}

Result<InputFile> InputFile::Open(const std::filesystem::path& file, const char* expected) {
  const auto refuse = [&](const std::string& found) {
    return Status::Error(file.string() + ": " + found + expected);
  };
  // O_NONBLOCK: opening a pipe must not wait for a writer.
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return refuse(std::strerror(errno));
  struct stat about {};
  InputFile opened(fd, 0, file.string(), expected);
  if (fstat(fd, &about) != 0) return refuse(std::strerror(errno));
  if (S_ISDIR(about.st_mode)) return refuse("is a folder");
  if (S_ISFIFO(about.st_mode)) return refuse("is a pipe");
  if (!S_ISREG(about.st_mode)) return refuse("is a device");
  opened.size_ = static_cast<std::size_t>(about.st_size);
  return opened;
}

Result<std::string> InputFile::Read(std::size_t offset, std::size_t count) const {
  std::string bytes(std::min(count, size_ - std::min(offset, size_)), '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        pread(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Status::Error(name_ + ": " + std::strerror(errno) + expected_);
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace styled::clip
