#include <algorithm>

#include "proto/rigs/types.h"
#include "sim/rigs/rig.h"

namespace styled::rigs {

#define STYLED_RIG(Name, ...) Result<std::unique_ptr<Rig>> Make##Name(const Options& options);
STYLED_RIGS(STYLED_RIG)
#undef STYLED_RIG

std::string Words() {
  std::string words(kNative.word);
  for (const RigType& rig : kRigs) words.append(", ").append(rig.word);
  return words;
}

Result<std::unique_ptr<Rig>> Make(const std::string& type, const Options& options) {
#define STYLED_RIG(Name, ...) \
  if (type == k##Name.word) return Make##Name(options);
  STYLED_RIGS(STYLED_RIG)
#undef STYLED_RIG
  return Status::Error("no rig is called '" + type + "'; expected " + Words());
}

bool HasQuirk(const Options& options, std::string_view quirk) {
  return std::find(options.quirks.begin(), options.quirks.end(), quirk) != options.quirks.end();
}

Status CheckOptions(const std::string& type, const Options& options, int max_performers,
                    std::initializer_list<std::string_view> quirks, std::size_t max_props) {
  if (max_performers > 0 && options.performers.size() > static_cast<std::size_t>(max_performers)) {
    return Status::Error(type + ": " + std::to_string(options.performers.size()) +
                         " performers, expected at most " + std::to_string(max_performers) +
                         " on one port");
  }
  if (options.props.size() > max_props) {
    return Status::Error(
        type + ": " + std::to_string(options.props.size()) + " props, expected " +
        (max_props == 0 ? "none: this rig has none" : "at most " + std::to_string(max_props)));
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
