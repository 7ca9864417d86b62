#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace styled {

// How deep a TOML text may nest: parts of one dotted key, and brackets within brackets. The
// project's own files need 3.
inline constexpr int kMaxTomlNesting = 16;

namespace toml_nesting {

// Returns the index behind the string that begins at `i`, and adds the line breaks inside it to
// `line`. An unclosed string ends at the end of its line, or of the text if it may span lines;
// toml++ refuses both.
inline std::size_t SkipString(std::string_view text, std::size_t i, int& line) {
  const char quote = text[i];
  const bool escapes = quote == '"';
  const auto quotes_at = [&](std::size_t at) {
    std::size_t count = 0;
    while (at + count < text.size() && text[at + count] == quote && count < 5) ++count;
    return count;
  };
  const bool spans_lines = quotes_at(i) >= 3;
  for (i += spans_lines ? 3 : 1; i < text.size(); ++i) {
    if (text[i] == '\n') {
      if (!spans_lines) return i;
      ++line;
    } else if (escapes && text[i] == '\\' && i + 1 < text.size() && text[i + 1] != '\n') {
      ++i;
    } else if (text[i] == quote) {
      if (!spans_lines) return i + 1;
      // Three quotes close the string. One or two more directly before them belong to its text.
      const std::size_t count = quotes_at(i);
      if (count >= 3) return i + count;
      i += count - 1;
    }
  }
  return i;
}

}  // namespace toml_nesting

// Returns the line, counted from 1, in which a TOML text nests deeper than kMaxTomlNesting; nothing
// if it does not.
//
// toml++ makes a table of each part of a dotted key, and walks and frees tables recursively. A key
// of 200,000 parts overflows the stack, which cannot be caught. (toml++ itself limits only nested
// values, to 256.) So texts from outside are checked here before toml++ parses them. The
// alternatives are worse: a forked child stalls the pipeline's thread with page faults, and a
// thread with a large stack costs a daemon that locks its memory all of that stack.
//
// Strings and comments are skipped as toml++ reads them. The two can differ only behind a syntax
// error, where toml++ stops. An accepted text has at most about 350 levels: 2 * 17 of a header,
// each part of which may be an array of tables; 17 of a key below it; and 17 + 1 more for each of
// 16 brackets.
inline std::optional<int> FindTooDeepToml(std::string_view text) {
  int line = 1, brackets = 0, dots = 0;  // dots since the last key or value ended
  for (std::size_t i = 0; i < text.size();) {
    switch (text[i]) {
      case '#':
        i = std::min(text.find('\n', i), text.size());
        continue;
      case '"':
      case '\'':
        i = toml_nesting::SkipString(text, i, line);
        continue;
      case '.':
        if (++dots > kMaxTomlNesting) return line;
        break;
      case '[':
      case '{':
        if (++brackets > kMaxTomlNesting) return line;
        dots = 0;
        break;
      case ']':
      case '}':
        brackets = std::max(0, brackets - 1);
        dots = 0;
        break;
      case '\n':
        ++line;
        dots = 0;
        break;
      case ',':
      case '=':
        dots = 0;
        break;
      default:
        break;
    }
    ++i;
  }
  return std::nullopt;
}

// The error message for such a text.
inline std::string TooDeepToml() {
  return "nested too deep; expected keys of at most " + std::to_string(kMaxTomlNesting + 1) +
         " parts, and brackets at most " + std::to_string(kMaxTomlNesting) + " deep";
}

}  // namespace styled
