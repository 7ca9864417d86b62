#pragma once

#include <vector>

#include "model/base/status.h"
#include "model/train/dataset.h"

namespace styled::train {

// Turns the joints of every clip that names a person to the carriage of the clips' own performers,
// as neutral::Neutral does live. It uses the carriage shown by all clips of this person, relative
// to the reference of the neutral clips without a person (MeasureReference). The hips' place stays.
// Errors: there is no such reference; a person never stands or walks upright in their clips. Pinned
// by tests/unit/train/persons_test.cpp.
Status RemovePersons(double rate_hz, std::vector<TrainingClip>& clips);

}  // namespace styled::train
