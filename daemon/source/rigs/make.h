#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Makes the translator for config.type by Make<Name>() of its row in proto/rigs/types.h; null for
// the native protocol, which needs none.
std::unique_ptr<Translator> MakeTranslator(const config::Source& config);

}  // namespace styled::source
