#pragma once

#include <span>
#include <string>
#include <string_view>

namespace styled::stylectl {

// Edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`, ASCII case ignored.
int Distance(std::string_view a, std::string_view b);

// The one of `names` nearest to `wrong`, if at most a third of the longer one (at least 2) has to
// be edited or one begins with the other; "" if none is near. Ties: the first.
std::string Nearest(std::string_view wrong, std::span<const std::string> names);

// "a, b, c".
std::string Join(std::span<const std::string> names);

}  // namespace styled::stylectl
