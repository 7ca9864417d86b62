#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "model/base/status.h"

namespace styled::clip {

// A regular file that is open for reading. Folders, pipes and devices are refused, so that no path
// can block the reader or fill the memory. Errors name the file and its kind, and end with
// `expected`, e.g. ", expected a BVH file". Blocks; allocates.
class InputFile {
 public:
  static Result<InputFile> Open(const std::filesystem::path& file, const char* expected);
  ~InputFile();
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;
  InputFile(const InputFile&) = delete;

  std::size_t size() const { return size_; }  // bytes, at the time of opening
  // Reads `count` bytes from `offset`, fewer at the end of the file.
  Result<std::string> Read(std::size_t offset, std::size_t count) const;

 private:
  InputFile(int fd, std::size_t size, std::string name, const char* expected);

  int fd_;
  std::size_t size_;
  std::string name_;
  const char* expected_;
};

}  // namespace styled::clip
