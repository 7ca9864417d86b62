#include "daemon/source/rigs/make.h"

#include <string_view>

#include "proto/rigs/types.h"

namespace styled::source {
namespace {

constexpr bool EveryTypeIsFoundByItsName() {
  for (const rigs::SourceType& type : rigs::kSourceTypes) {
    if (rigs::FindSourceType(type.name) != &type) return false;
  }
  return true;
}
static_assert(EveryTypeIsFoundByItsName(), "two rows of types.h share a name");

}  // namespace

#define STYLED_RIG(Name, ...) std::unique_ptr<Translator> Make##Name(const config::Source& config);
STYLED_RIGS(STYLED_RIG)
#undef STYLED_RIG

std::unique_ptr<Translator> MakeTranslator(const config::Source& config) {
  const std::string_view rig = rigs::FindSourceType(config.type)->rig->word;
#define STYLED_RIG(Name, ...) \
  if (rig == rigs::k##Name.word) return Make##Name(config);
  STYLED_RIGS(STYLED_RIG)
#undef STYLED_RIG
  return nullptr;
}

}  // namespace styled::source
