#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "model/train/judge/judge_data.h"
#include "model/train/judge/judge_html.h"

namespace styled::judge {

// A performer who stands, goes over into a posture that no training set has, stays in it, and gets
// up again: nothing but standing for twenty seconds, sitting, crouching, a fall on the back within
// half a second and lying there, lying face down. Made from `standing`, a pose of a real clip; 120
// Hz.
struct ForeignMotion {
  std::string name;
  Poses poses;
  std::size_t held_from = 0, held_to = 0;  // frames in the posture
};
std::vector<ForeignMotion> ForeignMotions(const body::Pose& standing);

// What the stylist makes of them, over all styles: prints a table and returns it. How far rec is
// from the input, how many of the frames in the posture are flagged out_of_domain, how far their
// joints are turned by the style, how deep the body goes below the input's lowest joint, and the
// largest turn of a joint between two frames. Scenes of two styles go to `scenes`.
nlohmann::json JudgeForeign(const Data& data, const Styler& styler, const stylist::Options& options,
                            std::vector<Scene>& scenes);

}  // namespace styled::judge
