#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/base/status.h"

namespace styled::train::st_gcn_causal {

// A file of a style library, NAME.json, as the daemon writes and reads them. Other content stays as
// it is.
struct StyleFile {
  nlohmann::json all;       // the object
  std::string name;         // of the style; the file's stem
  std::string weights;      // the hash of the weights that it was made with
  std::vector<float> code;  // the style, in any form of net::StyleCode; finite
};

// Errors name the file, and what was expected.
Result<StyleFile> ReadStyleFile(const std::filesystem::path& file);
// Writes the style again with its name and code, atomically: `name` becomes the file's stem.
Status WriteStyleFile(StyleFile style, const std::filesystem::path& file);

}  // namespace styled::train::st_gcn_causal
