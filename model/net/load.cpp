#include "model/net/load.h"

#include <algorithm>
#include <array>
#include <vector>

#include "model/net/erd/stylizer.h"
#include "model/net/offset/stylizer.h"
#include "model/net/weights_file.h"

namespace styled::net {
namespace {

// A network family: its name in weights files, and the function that reads the family's part.
struct Family {
  const char* name;
  Result<std::shared_ptr<const Stylizer>> (*load)(WeightsFile& file);
};
constexpr std::array kFamilies = {
    Family{kStyleErd, erd::Load},
    Family{offset::kFamily, offset::Load},
};

std::string FamilyNames() {
  std::string names;
  for (const Family& family : kFamilies) {
    names += (names.empty() ? "\"" : "\" or \"") + std::string(family.name);
  }
  return names + '"';
}

}  // namespace

Result<std::shared_ptr<const Stylizer>> Load(const std::filesystem::path& file) {
  const Result<std::vector<std::byte>> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return Parse(bytes.value(), file.string());
}

Result<std::shared_ptr<const Stylizer>> Parse(std::span<const std::byte> bytes,
                                              const std::string& name) {
  Result<WeightsFile> file = ParseWeights(bytes, name);
  if (!file.ok()) return file.status();
  const std::string& wanted = file.value().model.family;
  const auto* const family =
      std::find_if(kFamilies.begin(), kFamilies.end(),
                   [&wanted](const Family& candidate) { return candidate.name == wanted; });
  if (family != kFamilies.end()) return family->load(file.value());
  Faults faults(name);
  faults.Key("family", FamilyNames(), Shown(wanted));
  return faults.status();
}

}  // namespace styled::net
