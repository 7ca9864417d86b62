#pragma once

#include <string>
#include <string_view>

namespace styled::clip {

// A text file as UTF-8, without the NUL and Ctrl-Z bytes that some programs put at its end. Of
// UTF-16 with a byte order mark it is made in `utf8`, otherwise it is a part of `text`, so that a
// large file is not copied. An odd last byte of UTF-16 is left out. Any thread; allocates for
// UTF-16 alone.
std::string_view PlainText(std::string_view text, std::string& utf8);

}  // namespace styled::clip
