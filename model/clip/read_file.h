#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "model/base/status.h"

namespace styled::clip {

// An ordinary file that is open for reading. Folders, pipes and devices are refused, so that no
// path can keep the reader waiting or fill the memory. Errors name the file and say what it is;
// `expected` ends them, e.g. ", expected a BVH file". Blocks; allocates.
class InputFile {
 public:
  static Result<InputFile> Open(const std::filesystem::path& file, const char* expected);
  ~InputFile();
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&&) = delete;
  InputFile(const InputFile&) = delete;

  std::size_t size() const { return size_; }  // bytes, when it was opened
  // `count` bytes from `offset` on, fewer where the file ends. Refuses what cannot be read.
  Result<std::string> Read(std::size_t offset, std::size_t count) const;

 private:
  InputFile(int fd, std::size_t size, std::string name, const char* expected);

  int fd_;
  std::size_t size_;
  std::string name_;
  const char* expected_;
};

}  // namespace styled::clip
