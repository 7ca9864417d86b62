#include "model/net/shipped_weights.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <set>
#include <string>
#include <system_error>
#include <vector>

namespace styled::net {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".safetensors";
// The first that is installed is used where no file is named: v2 has more styles, but is not for
// commercial use and in a package of its own.
constexpr std::array kDefaults{"v2.safetensors", "open.safetensors"};

// The places of shipped weights: in an installation, in the source tree of a build, in the system.
std::vector<fs::path> Folders(std::vector<fs::path> folders = {}) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (!error) {
    folders.push_back(program / "../share/styled/weights");
    folders.push_back(program / "../../../model/weights");  // build/PRESET/bin
  }
  folders.emplace_back("/usr/share/styled/weights");
  return folders;
}

}  // namespace

Result<fs::path> FindWeights(const fs::path& given, const WeightsPlaces& places) {
  fs::path wanted = given;
  if (const char* from_environment = std::getenv("STYLED_WEIGHTS");
      given.empty() && from_environment != nullptr) {
    wanted = from_environment;
  }
  std::vector<fs::path> candidates;
  if (wanted.empty()) {
    for (const fs::path& folder : Folders(places.first)) {
      for (const char* name : kDefaults) candidates.push_back(folder / name);
    }
  } else {
    candidates.push_back(wanted);
  }
  if (!wanted.empty() && !wanted.has_parent_path()) {
    fs::path name = wanted;
    if (name.extension() != kExtension) name += kExtension;
    for (const fs::path& folder : Folders(places.first)) candidates.push_back(folder / name);
  }
  std::set<fs::path> looked;
  std::string list;
  for (const fs::path& candidate : candidates) {
    std::error_code error;
    const fs::path file = candidate.lexically_normal();
    if (fs::is_regular_file(candidate, error)) return file;
    if (looked.insert(file).second) list += (list.empty() ? "" : ", ") + file.string();
  }
  // The list is last: it is long, and a reader with little room cuts the end.
  return Status::Error(std::string("no weights file: expected a .safetensors file (") + places.how +
                       "), looked for " + list);
}

bool IsShippedDefault(const fs::path& file) {
  for (const fs::path& folder : Folders()) {
    for (const char* name : kDefaults) {
      std::error_code error;
      if (fs::equivalent(folder / name, file, error) && !error) return true;
      if (fs::exists(folder / name, error)) break;  // it is the default of this folder
    }
  }
  return false;
}

std::vector<fs::path> OtherShippedWeights(const fs::path& file) {
  std::vector<fs::path> others;
  for (const fs::path& folder : Folders()) {
    std::error_code error;
    if (!fs::equivalent(folder, file.parent_path(), error)) continue;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      const fs::path name = entry.path().filename();
      if (name.extension() == kExtension && name != file.filename()) others.push_back(name);
    }
    break;
  }
  std::sort(others.begin(), others.end());
  return others;
}

}  // namespace styled::net
