#pragma once

#include <memory>

#include "daemon/config/config.h"
#include "daemon/source/translator.h"

namespace styled::source {

// Xsens MVN (proto/rigs/mvn): a performer for each character of each sender, called as MVN calls
// it, else `config.performer`; NAME-2, ... where a name is taken. Poses of type 02, or of type 01
// where no 02 comes; the skeleton from type 13, or from the first pose where none comes within
// 1.5 s; fingers pass through, props are left out. Body in the stream's own axes and units.
//
// A sample may come in several datagrams, in order: it is a frame as soon as it has the segments
// that its headers count, whether or not one is marked as the last. One that is replaced or ended
// before is counted (source.incomplete) and said at most once a second.
// Pinned by tests/unit/mvn/translator_test.cpp.
std::unique_ptr<Translator> MakeMvn(const config::Source& config);

}  // namespace styled::source
