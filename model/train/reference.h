#pragma once

#include <optional>
#include <span>

#include "model/neutral/carriage.h"
#include "model/train/dataset.h"

namespace styled::train {

// How the performers of training clips stand, walk and run in neutral (neutral::Reference): the
// mean over all frames of style 0 that name no other person, each counted as far as
// neutral::JudgeOrdinary finds it ordinary, and its mirror image; where nobody runs, that of
// walking. Nothing where no such frame stands, or none walks. Pinned by
// tests/unit/train/reference_test.cpp.
std::optional<neutral::Reference> MeasureReference(std::span<const TrainingClip> clips,
                                                   double rate_hz);

}  // namespace styled::train
