#pragma once

#include <span>
#include <string>
#include <string_view>

namespace styled::stylectl {

// The number of edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`; ASCII
// case is ignored.
int Distance(std::string_view a, std::string_view b);

// The entry of `names` nearest to `wrong`. It is near enough if the edits are at most a third of
// the longer name's length (at least 2 are allowed), or if one name begins with the other; else the
// result is "". Ties: the first.
std::string Nearest(std::string_view wrong, std::span<const std::string> names);

// "a, b, c".
std::string Join(std::span<const std::string> names);

}  // namespace styled::stylectl
