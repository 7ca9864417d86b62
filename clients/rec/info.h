#pragma once

#include <ostream>

#include "proto/recording/reader.h"

namespace styled::rec {

// Reads all of `reader` and says what is in it, for people or as one JSON object.
void Info(recording::Reader& reader, bool json, std::ostream& out);

}  // namespace styled::rec
