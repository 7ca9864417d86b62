#pragma once

#include <filesystem>

#include "model/base/status.h"

namespace styled::net {

// Finds the weights file to use: `given` if not empty, else $STYLED_WEIGHTS, else the shipped file,
// relative to the running program: in the source tree of a build, or in ../share/styled/weights of
// an installation. The error lists the places searched. Start-up only.
Result<std::filesystem::path> FindWeights(const std::filesystem::path& given);

}  // namespace styled::net
