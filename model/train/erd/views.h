#pragma once

#include <torch/torch.h>

#include <cstdint>

namespace styled::train::style_erd {

// A critic's view of a window's standardized positions and velocities, [T, B, 126]: everything (Tao
// et al. 2022), the movement alone, or the legs alone. A critic of everything is satisfied when the
// poses are right, long before their movement is, because a single part has little influence on its
// decision.
enum class View { kWhole, kMovement, kLegs };

// Features of a view: 126; 126; 48, of the eight joints below the hips.
int64_t FeaturesOf(View view);

// kMovement: minus the window's mean, so that posture and the performer's speed, which a style must
// not change, have no effect.
torch::Tensor Seen(const torch::Tensor& judged, View view);

}  // namespace styled::train::style_erd
