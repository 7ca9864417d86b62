#include "model/tools/stylize/files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>

namespace styled::stylize {
namespace {

namespace fs = std::filesystem;

std::optional<FileId> IdOf(const std::string& file) {
  struct stat found {};
  if (stat(file.c_str(), &found) != 0) return std::nullopt;
  return FileId{found.st_dev, found.st_ino};
}

bool IsClip(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return (extension == ".bvh" || extension == ".glb" || extension == ".vrma") &&
         !file.filename().string().starts_with(".");
}

// `locked`: folders inside that cannot be read.
template <typename Iterator>
std::string Gather(const fs::path& folder, std::vector<fs::path>& found,
                   std::vector<fs::path>& locked) {
  std::error_code error;
  Iterator entry(folder, error);
  while (!error && entry != Iterator()) {
    std::error_code unknown;
    const bool folder_itself = entry->is_directory(unknown);
    if constexpr (std::is_same_v<Iterator, fs::recursive_directory_iterator>) {
      if (folder_itself && entry->path().filename().string().starts_with(".")) {
        entry.disable_recursion_pending();
      } else if (folder_itself && access(entry->path().c_str(), R_OK | X_OK) != 0) {
        entry.disable_recursion_pending();
        locked.push_back(entry->path());
      }
    }
    if (!folder_itself && IsClip(entry->path())) found.push_back(entry->path());
    entry.increment(error);
  }
  return error ? error.message() : "";
}

void FindInFolder(const std::string& folder, bool recursive, std::vector<Input>& inputs) {
  std::vector<fs::path> found, locked;
  const std::string wrong = recursive
                                ? Gather<fs::recursive_directory_iterator>(folder, found, locked)
                                : Gather<fs::directory_iterator>(folder, found, locked);
  for (const fs::path& inner : locked) {
    inputs.push_back({inner.string(), "", "", inner.string() + ": cannot be read: no permission"});
  }
  if (!wrong.empty()) {
    inputs.push_back({folder, "", "", folder + ": cannot be read: " + wrong});
  } else if (found.empty()) {
    inputs.push_back({folder, "", "",
                      folder +
                          ": found a folder without .bvh, .glb and .vrma files, expected some" +
                          (recursive ? "" : " (--recursive looks into the folders in it)")});
  }
  std::sort(found.begin(), found.end());
  for (const fs::path& file : found) {
    const fs::path below = file.parent_path().lexically_relative(folder);
    inputs.push_back(
        {file.string(), file.stem().string(), below.empty() ? "." : below.string(), ""});
  }
}

// A file descriptor of a new temporary file, and its name.
Result<std::string> TemporaryFile(const std::string& extension) {
  std::error_code error;
  std::string name = (fs::temp_directory_path(error) / ("stylize-XXXXXX" + extension)).string();
  const int file = mkstemps(name.data(), static_cast<int>(extension.size()));
  if (file < 0) return Status::Error(name + ": cannot be made: " + std::strerror(errno));
  close(file);
  return name;
}

}  // namespace

std::vector<Input> FindInputs(const std::vector<std::string>& named, bool recursive) {
  std::vector<Input> inputs;
  for (const std::string& file : named) {
    std::error_code error;
    if (file == kStandard) {
      inputs.push_back({file, "stdin", ".", ""});
    } else if (fs::is_directory(file, error)) {
      FindInFolder(file, recursive, inputs);
    } else {
      inputs.push_back({file, fs::path(file).stem().string(), ".", ""});
    }
  }
  return inputs;
}

Result<std::string> FillPattern(const std::string& pattern, const Words& words) {
  std::string filled;
  for (std::size_t at = 0; at < pattern.size();) {
    const std::size_t open = pattern.find('{', at);
    filled += pattern.substr(at, open == std::string::npos ? open : open - at);
    if (open == std::string::npos) break;
    const std::size_t close = pattern.find('}', open);
    const std::string word =
        close == std::string::npos ? pattern.substr(open) : pattern.substr(open, close - open + 1);
    if (word == "{name}") {
      filled += words.name;
    } else if (word == "{dir}") {
      filled += words.dir;
    } else if (word == "{style}") {
      filled += words.style;
    } else {
      return Status::Error(pattern + ": found " + word + ", expected {name}, {dir} or {style}");
    }
    at = close + 1;
  }
  return filled;
}

void Guard::Reads(const std::string& file, const std::string& what) {
  if (const auto id = IdOf(file)) read_.emplace_back(*id, what + " " + file);
}

Status Guard::Check(const std::string& file) const {
  struct stat found {};
  if (lstat(file.c_str(), &found) != 0) return Status::Ok();
  if (const auto id = IdOf(file)) {
    for (const auto& [read, what] : read_) {
      if (read == *id) {
        return Status::Error(file + ": is " + what + ", expected another file to write");
      }
    }
    if (written_.contains(*id)) {
      return Status::Error(file + ": is already an output of this run (by a link)");
    }
  }
  // A dangling link is written through. A link cycle has no status at all.
  std::error_code error;
  const fs::file_type type = fs::status(file, error).type();
  if (type == fs::file_type::none) {
    return Status::Error(file + ": cannot be looked at: " + error.message());
  }
  if (type != fs::file_type::not_found && type != fs::file_type::regular) {
    return Status::Error(file + ": is not an ordinary file, expected one to write");
  }
  if (overwrite_) return Status::Ok();
  return Status::Error(file + ": exists, expected a new file; --overwrite replaces it");
}

Status Guard::Write(const std::string& file,
                    const std::function<Status(const std::string&)>& write) {
  if (Status status = Check(file); !status.ok()) return status;
  std::error_code error;
  // A link keeps its target, and the target is replaced.
  fs::path target = file;
  if (fs::is_symlink(target, error)) target = fs::weakly_canonical(target, error);
  if (target.has_parent_path()) {
    fs::create_directories(target.parent_path(), error);
    if (error) {
      return Status::Error(target.parent_path().string() + ": cannot be made: " + error.message());
    }
  }
  const fs::path fresh =
      target.parent_path() / (".stylize-" + std::to_string(getpid()) + target.extension().string());
  Status status = write(fresh.string());
  if (status.ok()) {
    fs::rename(fresh, target, error);
    if (error) status = Status::Error(file + ": cannot be written: " + error.message());
  }
  if (!status.ok()) {
    fs::remove(fresh, error);
    // The message is about the output, not about the file on the way to it.
    std::string text = status.message();
    if (const auto at = text.find(fresh.string()); at != std::string::npos) {
      text.replace(at, fresh.string().size(), file);
    }
    return Status::Error(text);
  }
  if (const auto id = IdOf(file)) written_.insert(*id);
  return Status::Ok();
}

Status WriteToStandardOutput(const std::string& extension,
                             const std::function<Status(const std::string&)>& write) {
  const auto file = TemporaryFile(extension);
  if (!file.ok()) return file.status();
  Status status = write(file.value());
  std::FILE* const stream = status.ok() ? std::fopen(file.value().c_str(), "rb") : nullptr;
  unlink(file.value().c_str());
  if (!status.ok()) return status;
  if (stream == nullptr) return Status::Error(file.value() + ": cannot be read again");
  std::array<char, 1 << 16> block;
  bool good = true;
  for (std::size_t got = block.size(); good && got == block.size();) {
    got = std::fread(block.data(), 1, block.size(), stream);
    good = std::fwrite(block.data(), 1, got, stdout) == got;
  }
  std::fclose(stream);
  good = std::fflush(stdout) == 0 && good;
  return good ? Status::Ok() : Status::Error("standard output: cannot be written");
}

Result<std::string> ReadStandardInput() {
  constexpr std::size_t kMaxSize = std::size_t{1} << 31;
  std::string text;
  std::array<char, 1 << 16> block;
  while (const std::size_t got = std::fread(block.data(), 1, block.size(), stdin)) {
    text.append(block.data(), got);
    if (text.size() > kMaxSize) {
      return Status::Error("standard input: found more than 2 GiB, expected a clip");
    }
  }
  if (std::ferror(stdin) != 0) return Status::Error("standard input: cannot be read");
  return text;
}

}  // namespace styled::stylize
