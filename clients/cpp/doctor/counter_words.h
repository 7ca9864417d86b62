#pragma once

#include <string>
#include <string_view>

namespace styled::doctor {

// The explanation of a counter in daemon/OPERATING.md. The page itself is compiled into the
// program, so that both texts are the same (clients/cpp/doctor/embed.cmake).
struct CounterWords {
  bool known = false;           // the page has a row for it
  bool trouble = false;         // its growth is logged
  bool always = false;          // it always has a cause to find; otherwise it is normal at a low
                                // rate
  std::string meaning, change;  // plain text; `change` may be ""
};
CounterWords WordsOf(std::string_view counter);

}  // namespace styled::doctor
