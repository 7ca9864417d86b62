#include "model/net/shipped_weights.h"

#include <cstdlib>
#include <string>
#include <system_error>
#include <vector>

namespace styled::net {

Result<std::filesystem::path> FindWeights(const std::filesystem::path& given) {
  namespace fs = std::filesystem;
  std::vector<fs::path> candidates;
  if (!given.empty()) {
    candidates = {given};
  } else if (const char* from_environment = std::getenv("STYLED_WEIGHTS")) {
    candidates = {from_environment};
  } else {
    constexpr const char* kShipped = "v1.safetensors";
    std::error_code error;
    const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
    if (!error) {
      candidates.push_back(folder / "../share/styled/weights" / kShipped);
      candidates.push_back(folder / "../../../model/weights" / kShipped);  // build/PRESET/bin
    }
    candidates.push_back(fs::path("/usr/share/styled/weights") / kShipped);
  }
  std::string looked;
  for (const fs::path& candidate : candidates) {
    std::error_code error;
    if (fs::is_regular_file(candidate, error)) return candidate.lexically_normal();
    looked += (looked.empty() ? "" : ", ") + candidate.lexically_normal().string();
  }
  return Status::Error("no weights file: looked for " + looked +
                       "; expected a .safetensors file (option --weights or STYLED_WEIGHTS)");
}

}  // namespace styled::net
