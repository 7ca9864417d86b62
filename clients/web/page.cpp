#include "clients/web/page.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

namespace styled::web {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxBytes = 64 << 20;

constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".txt", "text/plain; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".json", "application/json"},
    {".map", "application/json"},
    {".woff2", "font/woff2"},
    {".wasm", "application/wasm"},
}};

std::string_view TypeOf(const fs::path& file) {
  const std::string extension = file.extension().string();
  for (const auto& [ending, type] : kTypes) {
    if (ending == extension) return type;
  }
  return "application/octet-stream";
}

}  // namespace

Result<Page> Page::Load(const std::string& folder) {
  Page page;
  std::uintmax_t total = 0;
  std::error_code error;
  fs::recursive_directory_iterator entries(folder, error);
  for (; !error && entries != fs::recursive_directory_iterator(); entries.increment(error)) {
    if (!entries->is_regular_file()) continue;
    total += entries->file_size(error);
    if (error || total > kMaxBytes) {
      return Status::Error("--page " + folder + ": holds more than 64 MiB, expected a built page");
    }
    std::ifstream in(entries->path(), std::ios::binary);
    std::string name("/");
    name += entries->path().lexically_relative(folder).generic_string();
    PageFile& file = page.files_[name];
    file.type = TypeOf(entries->path());
    file.bytes.assign(std::istreambuf_iterator<char>(in), {});
    file.forever = name.starts_with("/assets/");
  }
  if (error) return Status::Error("--page " + folder + ": " + error.message());
  if (!page.files_.contains("/index.html")) {
    return Status::Error("--page " + folder + ": has no index.html, expected a built page");
  }
  return page;
}

const PageFile* Page::Find(std::string_view target) const {
  target = target.substr(0, target.find('?'));
  const auto file = files_.find(target == "/" ? "/index.html" : target);
  return file == files_.end() ? nullptr : &file->second;
}

std::string FindPage() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return "";
  for (const char* place : {"../share/styled/web", "../web"}) {
    const fs::path folder = (program.parent_path() / place).lexically_normal();
    if (fs::exists(folder / "index.html", error)) return folder.string();
  }
  return "";
}

}  // namespace styled::web
