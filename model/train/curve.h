#pragma once

#include <filesystem>

#include "model/base/status.h"

namespace styled::train {

// Draws a CSV file whose first two columns are iteration and elapsed_s as an SVG picture: a panel
// per further column, over minutes, with axes. Errors name the file.
Status DrawCurve(const std::filesystem::path& csv, const std::filesystem::path& svg);

}  // namespace styled::train
