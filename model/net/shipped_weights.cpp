#include "model/net/shipped_weights.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <system_error>
#include <vector>

namespace styled::net {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".safetensors";
constexpr const char* kDefault = "v2.safetensors";
constexpr const char* kOpen = "open.safetensors";

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
  const bool any = wanted.empty();
  if (any) {
    wanted = kDefault;
  } else {
    candidates.push_back(wanted);
  }
  if (!wanted.has_parent_path()) {
    fs::path name = wanted;
    if (name.extension() != kExtension) name += kExtension;
    for (const fs::path& folder : Folders(places.first)) {
      candidates.push_back(folder / name);
      if (any && places.open_will_do) candidates.push_back(folder / kOpen);
    }
  }
  std::string looked;
  for (const fs::path& candidate : candidates) {
    std::error_code error;
    if (fs::is_regular_file(candidate, error)) return candidate.lexically_normal();
    looked += (looked.empty() ? "" : ", ") + candidate.lexically_normal().string();
  }
  return Status::Error("no weights file: looked for " + looked +
                       "; expected a .safetensors file (" + places.how + ")");
}

bool IsShippedDefault(const fs::path& file) {
  const std::vector<fs::path> folders = Folders();
  return std::any_of(folders.begin(), folders.end(), [&file](const fs::path& folder) {
    std::error_code error;
    return fs::equivalent(folder / kDefault, file, error) && !error;
  });
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
