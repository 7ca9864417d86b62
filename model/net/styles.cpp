#include "model/net/styles.h"

#include <algorithm>
#include <cctype>

namespace styled::net {

int FindStyle(const Styles& styles, std::string_view name) {
  const auto same = [name](std::string_view other) {
    return std::equal(
        name.begin(), name.end(), other.begin(), other.end(),
        [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
  };
  for (std::size_t s = 0; s < styles.size(); ++s) {
    const StyleInfo& style = styles[s];
    if (style.retired) continue;
    if (same(style.name) || std::any_of(style.aliases.begin(), style.aliases.end(), same)) {
      return static_cast<int>(s);
    }
  }
  return -1;
}

}  // namespace styled::net
