#pragma once

#include <memory>

#include "model/base/status.h"
#include "model/net/clip_stylizer.h"
#include "model/net/weights_file.h"

namespace styled::stgcn {

inline constexpr const char* kFamily = "st-gcn";  // in weights files

// A clip up to this long is normalized as a whole, as the paper does; a longer one in windows of
// kWindow frames, kHop apart, blended over their overlap with weights of sin². A window must hold
// several strides (2 s) so that its statistics are the style's and not a step's, and few different
// actions; 256 frames at 30 Hz are 8.5 s. No measurement on record picked these.
inline constexpr int kLongestWhole = 600;
inline constexpr int kWindow = 256, kHop = 128;

// Loads the networks of Park et al. 2021 from a weights file of the family kFamily (FORMAT.md). A
// prediction's reconstruction is the generator with the clip's own code, from the same encoding as
// the styled pose, so that the encoding's losses cancel in the change of style. Errors name the key
// or tensor. Allocates. Pinned by tests/unit/net/stgcn/stylizer_test.cpp.
Result<std::shared_ptr<const net::ClipStylizer>> Load(net::WeightsFile& file);

}  // namespace styled::stgcn
