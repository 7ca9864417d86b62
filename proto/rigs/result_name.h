#pragma once

#include <cstddef>
#include <string_view>

namespace styled::rigs {

// The name of a codec's result, for messages: `names` has one for each enumerator before kCount, in
// their order.
template <typename Result, std::size_t kNames>
constexpr std::string_view ResultName(Result result,
                                      const std::string_view (&names)[kNames]) noexcept {
  static_assert(kNames == static_cast<std::size_t>(Result::kCount));
  return result < Result::kCount ? names[static_cast<std::size_t>(result)] : "unknown";
}

}  // namespace styled::rigs
