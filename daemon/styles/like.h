#pragma once

#include <memory>
#include <span>
#include <vector>

#include "daemon/looks/runtime_config.h"
#include "model/base/status.h"
#include "model/base/work_limit.h"
#include "model/body/pose.h"
#include "proto/styled/v1/control.pb.h"

namespace styled::pipeline {

inline constexpr float kShortestTake_s = 1;

// Whether a Like can be executed, whatever its example shows: it needs a name, one example, and
// weights that accept examples. Any thread.
Status CheckLike(const RuntimeConfig& running, const v1::Like& like);

// Writes the description of a style of `space` for a reply.
void Describe(const net::StyleSpace& space, const MadeStyle& style, v1::LikeReply& reply);

// Finds the code of `style` again for the running weights, from the text of its example, a BVH clip
// (styles/library.h). Errors name `file`. Blocks as AddStyle does; `work` limits the reading.
Status MakeCodeAgain(const RuntimeConfig& running, const std::string& bvh, const std::string& file,
                     const WorkLimit& work, MadeStyle& style);

// Does the part of a Like that does not belong to the pipeline: reads the clip, finds the style's
// code, and makes a configuration whose network has the style; null for Like.measure. Fills
// `reply`. `take`: the performer's motion for
// Like.learn_s, at the network's rate. In `like` the example is then replaced by the code, so that
// a recording holds the style and not the example. `example`, if given, receives the example's
// poses at the network's rate; empty without one. `work`: the limit for reading the clip; beyond it
// the Like is refused before its code is computed, which takes a bounded time more. Blocks (10 s of
// clip: a tenth of a second); allocates at most 8 times the clip's bytes and 8 MiB besides the
// network; any thread but the pipeline's. Pinned by tests/e2e/like_test.cpp,
// tests/unit/clip/hostile_clips_test.cpp.
Result<std::shared_ptr<RuntimeConfig>> AddStyle(const RuntimeConfig& running, v1::Like& like,
                                                std::span<const body::Pose> take,
                                                v1::LikeReply& reply,
                                                std::vector<body::Pose>* example = nullptr,
                                                const WorkLimit& work = {});

}  // namespace styled::pipeline
