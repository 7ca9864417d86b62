#pragma once

#include <vector>

#include "model/base/status.h"
#include "model/train/dataset.h"

namespace styled::train {

// Turns the joints of every clip that names a person as the clips' own performers would hold them,
// as neutral::Neutral does live: by what all clips of this person show of how they stand and walk,
// against the reference of the neutral clips that name nobody (MeasureReference). The hips' place
// stays. Errors: there is no such reference; a person never stands or walks upright in their clips.
// Pinned by tests/unit/train/persons_test.cpp.
Status TakePersonsOut(double rate_hz, std::vector<TrainingClip>& clips);

}  // namespace styled::train
