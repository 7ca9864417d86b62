#pragma once

#include <string>
#include <string_view>

namespace styled::doctor {

// What daemon/OPERATING.md says about a counter: the page itself is in the program, so that both
// say the same (clients/doctor/embed.cmake).
struct CounterWords {
  bool known = false;           // the page has a row for it
  bool trouble = false;         // its growth is logged
  bool always = false;          // it always has a cause to find; otherwise it is normal at a low
                                // rate
  std::string meaning, change;  // plain text; `change` may be ""
};
CounterWords WordsOf(std::string_view counter);

}  // namespace styled::doctor
