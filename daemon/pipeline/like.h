#pragma once

#include <memory>

#include "daemon/pipeline/runtime_config.h"
#include "model/base/status.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

inline constexpr double kLongestExample_s = 60;

// Does the part of a Like that is not the pipeline's: reads the clip, finds the style's code, and
// makes a configuration whose network has the style; null after an error. Fills code, reason and
// result of `reply`. In `like` the clip is then replaced by the code, so that a recording holds the
// style and not the clip. Blocks (10 s of clip: a tenth of a second); allocates; any thread, but
// not the pipeline's. Pinned by tests/unit/daemon/like_test.cpp.
std::shared_ptr<const RuntimeConfig> AddStyle(const RuntimeConfig& running, v1::Like& like,
                                              v1::Reply& reply);

}  // namespace styled::pipeline
