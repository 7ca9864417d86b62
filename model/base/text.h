#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

// Text for humans: log lines, error messages, replies. Allocates; not for the hot path.
namespace styled {

// The shortest text that is parsed as exactly this number: "2", "0.8", "66.667", "100000", "1e+30",
// "nan". From 1e-4 to 1e9 without an exponent.
template <std::floating_point T>
std::string NumberText(T value) {
  const bool plain = value == 0 || (std::abs(value) >= T(1e-4) && std::abs(value) < T(1e9));
  std::array<char, 64> text;
  const auto end =
      plain ? std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed)
            : std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

// The same for a measured or computed number, rounded to `decimals` places behind the point.
template <std::floating_point T>
std::string NumberText(T value, int decimals) {
  const T scale = std::pow(T(10), static_cast<T>(decimals));
  return NumberText(std::round(value * scale) / scale);
}

// The UTF-8 character at the beginning of a text: its length in bytes, 1 to 4, and its code point.
// `bytes` is 0 if the text does not begin with a valid one (RFC 3629: no overlong form, no
// surrogate, at most U+10FFFF).
struct Utf8Character {
  std::size_t bytes = 0;
  std::uint32_t point = 0;
};
inline Utf8Character FirstUtf8(std::string_view text) {
  if (text.empty()) return {};
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return {1, first};
  const std::size_t bytes = first >= 0xF8   ? 0
                            : first >= 0xF0 ? 4
                            : first >= 0xE0 ? 3
                            : first >= 0xC0 ? 2
                                            : 0;
  if (bytes == 0 || bytes > text.size()) return {};
  std::uint32_t point = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return {};
    point = point << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
  if (point < kLeast[bytes] || point > 0x10FFFF || surrogate) return {};
  return {bytes, point};
}

inline bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = FirstUtf8(text).bytes;
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

// `text` as one printable line of valid UTF-8. An invalid byte becomes U+FFFD. Control characters,
// line separators and characters that change the direction of writing are escaped: \n, \x1b,
// \u202e. Text that would exceed `max_bytes` is cut and followed by "...".
inline std::string Printable(std::string_view text, std::size_t max_bytes) {
  std::string shown;
  std::array<char, 16> escaped;
  while (!text.empty()) {
    const Utf8Character character = FirstUtf8(text);
    const std::uint32_t point = character.point;
    const bool separates = point == 0x2028 || point == 0x2029;
    const bool turns = (point >= 0x202A && point <= 0x202E) || (point >= 0x2066 && point <= 0x2069);
    std::string_view next = text.substr(0, character.bytes);
    if (character.bytes == 0) {
      next = "\xEF\xBF\xBD";
    } else if (point == '\n') {
      next = "\\n";
    } else if (point == '\t') {
      next = "\\t";
    } else if (point < ' ' || (point >= 0x7F && point < 0xA0)) {
      std::snprintf(escaped.data(), escaped.size(), "\\x%02x", static_cast<unsigned>(point));
      next = escaped.data();
    } else if (separates || turns) {
      std::snprintf(escaped.data(), escaped.size(), "\\u%04x", static_cast<unsigned>(point));
      next = escaped.data();
    }
    if (shown.size() + next.size() > max_bytes) return shown + "...";
    shown += next;
    text.remove_prefix(character.bytes == 0 ? 1 : character.bytes);
  }
  return shown;
}

}  // namespace styled
