#pragma once

#include <optional>
#include <span>

#include "model/neutral/carriage.h"
#include "model/train/dataset.h"

namespace styled::train {

// The carriage of the performers of training clips while they stand, walk and run in neutral
// (neutral::Reference): the mean over all frames of style 0 that name no other person, each
// weighted by how ordinary neutral::JudgeOrdinary finds it, and its mirror image. Without runs, the
// carriage of walking is used for them. Empty if no such frame stands, or none walks. Pinned by
// tests/unit/train/reference_test.cpp.
std::optional<neutral::Reference> MeasureReference(std::span<const TrainingClip> clips,
                                                   double rate_hz);

}  // namespace styled::train
