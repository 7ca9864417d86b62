#pragma once

#include <cstddef>
#include <string>

namespace styled::judge {

// The digits of a SHA-256 (model/net/sha256.h) that tables show.
inline constexpr std::size_t kShownDigits = 16;
inline std::string Shown(const std::string& hash) { return hash.substr(0, kShownDigits); }

}  // namespace styled::judge
