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

int VaryingStyle(const Styles& styles, int style) {
  const StyleInfo& wanted = styles[static_cast<std::size_t>(style)];
  if (wanted.varies) return style;
  const auto same = [&wanted](const StyleInfo& other) {
    return other.varies && !other.retired && !wanted.original.empty() &&
           other.original == wanted.original;
  };
  const auto found = std::find_if(styles.begin(), styles.end(), same);
  return found == styles.end() ? -1 : static_cast<int>(found - styles.begin());
}

}  // namespace styled::net
