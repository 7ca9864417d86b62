#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "model/train/judge/data.h"
#include "model/train/judge/html.h"

namespace styled::judge {

// A performer who stands, moves into a posture that no training set has, stays in it, and gets up
// again. The motions: only standing for twenty seconds; sitting; crouching; a fall on the back
// within half a second, then lying; lying face down. Made from `standing`, a pose of a real clip;
// 120 Hz.
struct ForeignMotion {
  std::string name;
  Poses poses;
  std::size_t held_from = 0, held_to = 0;  // frames in the posture
};
std::vector<ForeignMotion> ForeignMotions(const body::Pose& standing);

// Runs them through the stylist in every style; prints a table and returns it. The figures: the
// distance of the reconstruction from the input, the share of frames in the posture that are
// flagged out of domain, how far the style rotates their joints, how far the body goes below the
// input's lowest joint, and the largest rotation of a joint between two frames. Scenes of two
// styles are added to `scenes`.
nlohmann::json JudgeForeign(const Data& data, const Styler& styler, const stylist::Options& options,
                            std::vector<Scene>& scenes);

}  // namespace styled::judge
