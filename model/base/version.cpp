#include "model/base/version.h"

#include "generated/commit.h"

namespace styled {

std::string VersionText(std::string_view program) {
  constexpr std::string_view kBuilt = STYLED_COMMIT;
  std::string text = std::string(program) + " " + STYLED_VERSION;
  if (!kBuilt.empty()) text.append(", commit ").append(kBuilt);
  return text;
}

}  // namespace styled
