#include "model/clip/plain_text.h"

#include <cstdint>

namespace styled::clip {
namespace {

void AppendUtf8(char32_t c, std::string& text) {
  const auto add = [&text](char32_t byte) { text += static_cast<char>(byte); };
  if (c < 0x80) return add(c);
  if (c < 0x800) {
    add(0xC0 | c >> 6);
  } else {
    if (c < 0x10000) {
      add(0xE0 | c >> 12);
    } else {
      add(0xF0 | c >> 18);
      add(0x80 | (c >> 12 & 0x3F));
    }
    add(0x80 | (c >> 6 & 0x3F));
  }
  add(0x80 | (c & 0x3F));
}

// `text` after the byte order mark; `low` and `high`: which byte of two is which. Half a surrogate
// pair becomes U+FFFD.
std::string FromUtf16(std::string_view text, std::size_t low, std::size_t high) {
  std::string utf8;
  const auto unit = [&](std::size_t at) -> char32_t {
    return static_cast<std::uint8_t>(text[at + low]) |
           static_cast<char32_t>(static_cast<std::uint8_t>(text[at + high])) << 8;
  };
  for (std::size_t at = 0; at + 1 < text.size(); at += 2) {
    char32_t c = unit(at);
    const bool first = c >= 0xD800 && c < 0xDC00;
    const char32_t next = first && at + 3 < text.size() ? unit(at + 2) : 0;
    if (next >= 0xDC00 && next < 0xE000) {
      c = 0x10000 + ((c - 0xD800) << 10) + (next - 0xDC00);
      at += 2;
    } else if (c >= 0xD800 && c < 0xE000) {
      c = 0xFFFD;
    }
    AppendUtf8(c, utf8);
  }
  return utf8;
}

}  // namespace

std::string_view PlainText(std::string_view text, std::string& utf8) {
  if (text.starts_with("\xFF\xFE")) text = utf8 = FromUtf16(text.substr(2), 0, 1);
  if (text.starts_with("\xFE\xFF")) text = utf8 = FromUtf16(text.substr(2), 1, 0);
  const std::size_t last = text.find_last_not_of(std::string_view("\0\x1A", 2));
  return text.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

}  // namespace styled::clip
