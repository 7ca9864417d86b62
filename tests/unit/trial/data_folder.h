#pragma once

#include <cstdlib>
#include <filesystem>

namespace styled::stylist {

// Rate at which real clips are styled.
inline constexpr double kRate_hz = 120;

// The folder of data outside the repository: STYLED_DATA, or `otherwise`.
inline std::filesystem::path DataFolder(const std::filesystem::path& otherwise) {
  const char* const set = std::getenv("STYLED_DATA");
  return set != nullptr ? std::filesystem::path(set) : otherwise;
}

}  // namespace styled::stylist
