#pragma once

#include <filesystem>

#include "model/base/status.h"

namespace styled::net {

// The weights file to use: `given` if not empty, else $STYLED_WEIGHTS, else the shipped file beside
// the running program: in the source tree of a build, or ../share/styled/weights of an
// installation. The error lists where it looked. Start-up only.
Result<std::filesystem::path> FindWeights(const std::filesystem::path& given);

}  // namespace styled::net
