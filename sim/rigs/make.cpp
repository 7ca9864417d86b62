#include <algorithm>
#include <array>

#include "sim/rigs/mocopi.h"
#include "sim/rigs/mvn.h"
#include "sim/rigs/natnet.h"
#include "sim/rigs/rig.h"
#include "sim/rigs/rokoko.h"
#include "sim/rigs/slimevr.h"
#include "sim/rigs/vmc.h"

namespace styled::rigs {
namespace {

struct Row {
  std::string_view type;
  Result<std::unique_ptr<Rig>> (*make)(const Options& options);
};
constexpr std::array kRows{
    Row{"mocopi", MakeMocopi}, Row{"mvn", MakeMvn},         Row{"natnet", MakeNatNet},
    Row{"rokoko", MakeRokoko}, Row{"slimevr", MakeSlimeVr}, Row{"vmc", MakeVmc},
};

}  // namespace

Result<std::unique_ptr<Rig>> Make(const std::string& type, const Options& options) {
  std::string known = "native";
  for (const Row& row : kRows) {
    if (row.type == type) return row.make(options);
    known.append(", ").append(row.type);
  }
  return Status::Error("no rig is called '" + type + "'; expected " + known);
}

Status CheckOptions(const std::string& type, const Options& options, int max_performers,
                    std::initializer_list<std::string_view> quirks) {
  if (max_performers > 0 && options.performers.size() > static_cast<std::size_t>(max_performers)) {
    return Status::Error(type + ": " + std::to_string(options.performers.size()) +
                         " performers, expected at most " + std::to_string(max_performers) +
                         " on one port");
  }
  for (const auto& quirk : options.quirks) {
    if (std::find(quirks.begin(), quirks.end(), quirk) != quirks.end()) continue;
    std::string known;
    for (const auto word : quirks) known.append(known.empty() ? "" : ", ").append(word);
    return Status::Error(type + ": quirk '" + quirk + "'" +
                         (known.empty() ? ", expected none" : ", expected one of " + known));
  }
  return Status::Ok();
}

}  // namespace styled::rigs
