#pragma once

#include <memory>

#include "model/base/status.h"
#include "model/net/stylizer.h"
#include "model/net/weights_file.h"

namespace styled::stgcn_causal {

inline constexpr const char* kFamily = "st-gcn-causal";  // in weights files

// Loads the causal network (network.h) from a weights file of the family kFamily (FORMAT.md).
// Predictions have no velocities. Errors name the key or tensor. Allocates. Pinned by
// tests/unit/net/stgcn_causal/stylizer_test.cpp.
Result<std::shared_ptr<const net::Stylizer>> Load(net::WeightsFile& file);

}  // namespace styled::stgcn_causal
