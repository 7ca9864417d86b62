#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "model/base/status.h"
#include "model/neutral/carriage.h"
#include "model/train/dataset.h"

namespace styled::judge {

// How the performers of training clips stand, walk and run in neutral (neutral::Reference): the
// mean over all frames of style 0, each counted as far as neutral::JudgeOrdinary finds it ordinary,
// and its mirror image; where nobody runs, that of walking. Nothing where no such frame stands, or
// none walks. Pinned by tests/unit/judge/judge_reference_test.cpp.
std::optional<neutral::Reference> MeasureReference(std::span<const train::TrainingClip> clips,
                                                   double rate_hz);

// Writes it into a weights file of any family, as the key "reference" (model/net/FORMAT.md).
// Tensors and all other keys but the version stay. Errors name the file.
Status WriteReference(const neutral::Reference& reference, const std::filesystem::path& weights);

// Both, for the training clips of a manifest.
Status MeasureAndWriteReference(const std::filesystem::path& manifest,
                                const std::filesystem::path& folder,
                                const std::filesystem::path& weights);

}  // namespace styled::judge
