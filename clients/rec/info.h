#pragma once

#include <ostream>

#include "proto/recording/reader.h"

namespace styled::rec {

// Reads all of `reader` and writes a summary of its contents, as text or as one JSON object.
void Info(recording::Reader& reader, bool json, std::ostream& out);

}  // namespace styled::rec
