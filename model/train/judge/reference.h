#pragma once

#include <filesystem>

#include "model/base/status.h"
#include "model/neutral/carriage.h"

namespace styled::judge {

// Writes a reference (train::MeasureReference) into a weights file of any family, as the key
// "reference" (model/net/FORMAT.md). Tensors and all other keys but the version stay. Errors name
// the file. Pinned by tests/unit/judge/reference_test.cpp.
Status WriteReference(const neutral::Reference& reference, const std::filesystem::path& weights);

// Measures the reference of a manifest's training clips, and writes it.
Status MeasureAndWriteReference(const std::filesystem::path& manifest,
                                const std::filesystem::path& folder,
                                const std::filesystem::path& weights);

}  // namespace styled::judge
