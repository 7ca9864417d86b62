#pragma once

#include <memory>

#include "model/base/status.h"
#include "model/net/stylizer.h"
#include "model/net/weights_file.h"

namespace styled::stgcn_causal {

inline constexpr const char* kFamily = "st-gcn-causal";  // in weights files

// The pose from which a change of style is measured, as a position between the reconstruction (0)
// and the input (1): 0 is the detail-preserving form, 1 the absolute one, filtered as a change.
// Picked by six styles of set 2, as live, means: at 0, 0.5, 1 the Fréchet distance is 22.8, 12.3,
// 6.9, the style recognized in 0.975, 0.967, 0.956, its movement in 0.55, 0.55, 0.54, content in
// 0.89 of all.
inline constexpr float kTowardInput = 0.5F;

// Loads the causal network (network.h) from a weights file of the family kFamily (FORMAT.md).
// Predictions have no velocities. Errors name the key or tensor. Allocates. Pinned by
// tests/unit/net/stgcn_causal/stylizer_test.cpp.
Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file);

}  // namespace styled::stgcn_causal
