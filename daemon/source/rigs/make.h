#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Where a rig is registered: a row of config::kSourceTypes, a line in make.cpp and its file in
// daemon/CMakeLists.txt.

// The translator for config.type, or null where that is no rig's protocol.
std::unique_ptr<Translator> MakeTranslator(const config::Source& config);

}  // namespace styled::source
