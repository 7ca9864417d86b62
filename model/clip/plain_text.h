#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace styled::clip {

// A text file as UTF-8 with line feeds, without the NUL and Ctrl-Z bytes that some programs put at
// its end: of UTF-16 with a byte order mark, and of lines that end in a carriage return alone.
// None: the text is like that already. An odd last byte of UTF-16 is left out. Any thread;
// allocates.
std::optional<std::string> PlainText(std::string_view text);

}  // namespace styled::clip
