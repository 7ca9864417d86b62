#pragma once

#include <cstdlib>
#include <filesystem>

namespace styled::stylist {

// Rate at which real clips are styled.
inline constexpr double kRate_hz = 120;

// The folder of data that is no part of the repository: STYLED_DATA, or shared/data beside it.
inline std::filesystem::path DataFolder() {
  const char* const set = std::getenv("STYLED_DATA");
  return set != nullptr ? set : STYLED_DATA_DEFAULT;
}

}  // namespace styled::stylist
