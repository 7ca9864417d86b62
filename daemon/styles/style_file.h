#pragma once

#include <cstddef>
#include <string>

#include "daemon/looks/runtime_config.h"
#include "model/base/status.h"

// The file of a style that was made from an example, as the library keeps it and clients exchange
// it: a JSON object with "format": "styled style 1", "name", "weights" (their hash, because the
// code is meaningful only with them), "licence" (theirs), "source", "seconds", "nearest",
// "distance", "example" (hash of the kept example, library.h) and "code". Unknown keys are
// accepted, and dropped when the daemon writes the file, so that no file grows by being stored.
// Memory and time in proportion to the text. Any thread; allocates. Pinned by
// tests/e2e/style_library_test.cpp, tests/unit/daemon/styles/style_file_test.cpp.
namespace styled::pipeline {

inline constexpr std::size_t kMaxStyleFileBytes = std::size_t{1} << 20U;

// Reads a style of `config`'s weights. Errors begin with `file` and name what was expected: at most
// kMaxStyleFileBytes of JSON, brackets at most 16 deep. Does not check whether the code fits the
// network. Of a style of other weights the part of the code that does not depend on them is taken.
// Where there is none, it is an error; or with `other_weights`, which is then set to their hash,
// the code is empty.
Result<MadeStyle> ParseStyleFile(const std::string& text, const std::string& file,
                                 const RuntimeConfig& config, std::string* other_weights = nullptr);
// The text of the style's file: at most twice as long as the shortest one with the same code, plus
// 1 KiB. With the longest code of a network, some thousand numbers, that is a tenth of
// kMaxStyleFileBytes, so that the file can be read again.
std::string FormatStyleFile(const MadeStyle& style, const RuntimeConfig& config);

}  // namespace styled::pipeline
