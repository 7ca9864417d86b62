#pragma once

#include <filesystem>
#include <vector>

#include "model/base/status.h"

namespace styled::net {

// Where FindWeights looks beyond the program's own places, and its error's last words.
struct WeightsPlaces {
  std::vector<std::filesystem::path> first;  // folders that are searched before the program's
  const char* how = "option --weights or STYLED_WEIGHTS";  // how a file is named
};

// Finds the weights file to use: `given` if not empty, else $STYLED_WEIGHTS, else the shipped v2,
// else the shipped open, which is installed without v2 by those who may not use it. A name without
// a folder that does not exist as a file here is searched among the shipped ones, with or without
// its ".safetensors". The error lists the places searched. Start-up only. Pinned by
// tests/e2e/tools_test.cpp.
Result<std::filesystem::path> FindWeights(const std::filesystem::path& given,
                                          const WeightsPlaces& places = {});

// Whether `file`, as FindWeights found it, is the shipped file of FindWeights("").
bool IsShippedDefault(const std::filesystem::path& file);

// The other weights in the folder of `file`, by name; empty if `file` is not a shipped one.
std::vector<std::filesystem::path> OtherShippedWeights(const std::filesystem::path& file);

}  // namespace styled::net
