#include "model/net/styles.h"

#include <algorithm>
#include <cctype>

namespace styled::net {
namespace {

bool IsSameName(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

}  // namespace

int FindStyle(const Styles& styles, std::string_view name) {
  const auto same = [name](std::string_view other) { return IsSameName(name, other); };
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

Result<int> FindContent(const Contents& contents, std::string_view name) {
  if (name.empty()) return kContentRecognized;
  const std::string named = "content '" + std::string(name) + "'";
  if (contents.empty()) return Status::Error(named + ": the network takes no content as input");
  if (IsSameName(name, kUnknownContent)) return kContentUnknown;
  for (std::size_t c = 0; c < contents.size(); ++c) {
    if (IsSameName(name, contents[c])) return static_cast<int>(c);
  }
  std::string choices = kUnknownContent;
  for (const std::string& content : contents) choices += ", " + content;
  return Status::Error("unknown " + named + "; expected one of " + choices);
}

}  // namespace styled::net
