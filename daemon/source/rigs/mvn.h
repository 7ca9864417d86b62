#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Xsens MVN (proto/rigs/mvn): a performer for each character of each sender, called as MVN calls
// it, else `config.performer`; NAME-2, ... where a name is taken. Poses of type 02, or of type 01
// where no 02 comes; the skeleton from type 13, or from the first pose where none comes within
// 1.5 s; fingers pass through, props are left out. Body in the stream's own axes and units.
std::unique_ptr<Translator> MakeMvn(const config::Source& config);

}  // namespace styled::source
