#pragma once

#include <torch/torch.h>

#include <cstdint>

namespace styled::train::style_erd {

// What a critic sees of a window's standardized positions and velocities, [T, B, 126]: everything
// (Tao et al. 2022), the movement alone, or the legs alone. A critic of everything is content when
// the poses are right, long before their movement is; what is in one part of it decides little.
enum class View { kWhole, kMovement, kLegs };

// Features of a view: 126; 126; 48, of the eight joints below the hips.
int64_t FeaturesOf(View view);

// kMovement: less the window's mean, so that neither posture nor the performer's speed, which a
// style must not change, says anything.
torch::Tensor Seen(const torch::Tensor& judged, View view);

}  // namespace styled::train::style_erd
