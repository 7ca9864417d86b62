#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/train/judge/judge_data.h"
#include "model/train/judge/judge_html.h"

namespace styled::judge {

// Weights under other conditions than "a recorded neutral clip at 120 Hz": each prints a table and
// returns it. All of it runs through the stylist, as live.

// As live rigs spoil the inputs, in both forms of the output, beside real clips of the target that
// are spoilt alike: what the judge itself loses by it.
nlohmann::json JudgePerturbed(const Data& data, const Styler& styler, const Evaluator& evaluator,
                              const stylist::Options& options);

// At the rates of rigs, 24 to 240 Hz. Jerk is the output's over the input's at that rate.
nlohmann::json JudgeRates(const Data& data, const Styler& styler, const Evaluator& evaluator,
                          const stylist::Options& options);

// Performers who move in a style already: from every style to every other, the network told
// neutral, and told what they are; then also to neutral. A row per own style, a column per target.
nlohmann::json JudgeStyledInputs(const Data& data, const Styler& styler, const Evaluator& evaluator,
                                 const stylist::Options& options);

// Clips of other rigs, which no judge knows: per clip the worst over styles of jerk (120 Hz, output
// over input) and of the largest turn of one joint between two frames; their first seconds go to
// `scenes`, for the report. Errors name the file.
Result<nlohmann::json> JudgeOtherClips(std::span<const std::filesystem::path> files,
                                       const Styler& styler, const stylist::Options& options,
                                       std::vector<Scene>& scenes);

}  // namespace styled::judge
