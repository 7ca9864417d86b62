#include "model/net/load.h"

#include <algorithm>
#include <array>
#include <vector>

#include "model/net/erd/stylizer.h"
#include "model/net/offset/stylizer.h"
#include "model/net/phase/stylizer.h"
#include "model/net/stgcn/stylizer.h"
#include "model/net/stgcn_causal/stylizer.h"
#include "model/net/weights_file.h"

namespace styled::net {
namespace {

// A network family: its name in weights files, the function that reads the family's part for either
// kind, whether it knows a space of styles, and whether its weights can be rounded.
struct Family {
  const char* name;
  Result<std::shared_ptr<const Stylizer>> (*load)(WeightsFile& file);
  Result<std::shared_ptr<const ClipStylizer>> (*load_clips)(WeightsFile& file) = nullptr;
  bool space = false;
  bool rounds = false;
};
constexpr std::array kFamilies = {
    Family{kStyleErd, erd::Load, nullptr, false, true},
    Family{offset::kFamily, offset::Load},
    Family{phase::kFamily, phase::Load, nullptr, true},
    Family{stgcn::kFamily, nullptr, stgcn::Load, true},
    Family{stgcn_causal::kFamily, stgcn_causal::Load, nullptr, true},
};

// The families that are `wanted`, as an error lists them.
std::string FamilyNames(bool (*wanted)(const Family& family)) {
  std::string names;
  for (const Family& family : kFamilies) {
    if (!wanted(family)) continue;
    names += (names.empty() ? "\"" : "\" or \"") + std::string(family.name);
  }
  return names + '"';
}

bool IsLive(const Family& family) { return family.load != nullptr; }

const Family* FindFamily(const std::string& name) {
  const auto* const found =
      std::find_if(kFamilies.begin(), kFamilies.end(),
                   [&name](const Family& candidate) { return candidate.name == name; });
  return found == kFamilies.end() ? nullptr : found;
}

const Family* FamilyOf(std::span<const std::byte> bytes) {
  const Result<WeightsFile> file = ParseWeights(bytes, "");
  return file.ok() ? FindFamily(file.value().model.family) : nullptr;
}

Result<WeightsFile> ParseFor(Precision precision, std::span<const std::byte> bytes,
                             const std::string& name) {
  Result<WeightsFile> file = ParseWeights(bytes, name);
  if (file.ok()) file.value().precision = precision;
  return file;
}

Result<AnyStylizer> LoadFamily(const Family& family, WeightsFile& file) {
  AnyStylizer any;
  if (family.load != nullptr) {
    auto network = family.load(file);
    if (!network.ok()) return network.status();
    any.frames = std::move(network.value());
  } else {
    auto network = family.load_clips(file);
    if (!network.ok()) return network.status();
    any.clips = std::move(network.value());
  }
  return any;
}

}  // namespace

Result<std::shared_ptr<const Stylizer>> Load(const std::filesystem::path& file,
                                             Precision precision) {
  const Result<std::vector<std::byte>> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return Parse(bytes.value(), file.string(), precision);
}

Result<std::shared_ptr<const Stylizer>> Parse(std::span<const std::byte> bytes,
                                              const std::string& name, Precision precision) {
  Result<WeightsFile> file = ParseFor(precision, bytes, name);
  if (!file.ok()) return file.status();
  const std::string& wanted = file.value().model.family;
  const Family* const family = FindFamily(wanted);
  if (family != nullptr && family->load != nullptr) return family->load(file.value());
  Faults faults(name);
  faults.Key(
      "family", FamilyNames(IsLive),
      Shown(wanted) + (family != nullptr ? ": it styles whole clips, not live streams" : ""));
  return faults.status();
}

Precision PrecisionNamed(std::string_view name) {
  return static_cast<Precision>(std::ranges::find(kPrecisions, name) - kPrecisions.begin());
}

bool CanBeRounded(std::span<const std::byte> bytes) {
  const Family* const family = FamilyOf(bytes);
  return family != nullptr && family->rounds;
}

bool KnowsStyleSpace(std::span<const std::byte> bytes) {
  const Family* const family = FamilyOf(bytes);
  return family != nullptr && family->space;
}

Result<AnyStylizer> LoadAny(const std::filesystem::path& file, Precision precision) {
  const Result<std::vector<std::byte>> bytes = ReadFile(file);
  if (!bytes.ok()) return bytes.status();
  return ParseAny(bytes.value(), file.string(), precision);
}

Result<AnyStylizer> ParseAny(std::span<const std::byte> bytes, const std::string& name,
                             Precision precision) {
  Result<WeightsFile> file = ParseFor(precision, bytes, name);
  if (!file.ok()) return file.status();
  const std::string& wanted = file.value().model.family;
  const Family* const family = FindFamily(wanted);
  if (family != nullptr) return LoadFamily(*family, file.value());
  Faults faults(name);
  faults.Key("family", FamilyNames([](const Family&) { return true; }), Shown(wanted));
  return faults.status();
}

std::string ClipFamilyNames() {
  return FamilyNames([](const Family& family) { return !IsLive(family); });
}
std::string SpaceFamilyNames() {
  return FamilyNames([](const Family& family) { return family.space; });
}

}  // namespace styled::net
