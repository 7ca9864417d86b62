#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// A rig is registered in three places: a row of config::kSourceTypes, a line in make.cpp, and its
// file in daemon/CMakeLists.txt.

// Makes the translator for config.type; null for types without a rig's protocol, and for natnet,
// whose transport makes its own.
std::unique_ptr<Translator> MakeTranslator(const config::Source& config);

}  // namespace styled::source
