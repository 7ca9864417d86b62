#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "model/train/judge/data.h"
#include "model/train/judge/html.h"

namespace styled::judge {

// Judges weights under other conditions than "a recorded neutral clip at 120 Hz". Each function
// prints a table and returns it. Everything runs through the stylist, as live.

// Inputs with the faults of live rigs, for both forms of the output. For comparison, real clips of
// the target with the same faults, which show the faults' effect on the judge itself.
nlohmann::json JudgePerturbed(const Data& data, const Styler& styler, const Evaluator& evaluator,
                              const stylist::Options& options);

// Inputs at the rates of rigs, 24 to 240 Hz. Jerk is the output's over the input's at that rate.
nlohmann::json JudgeRates(const Data& data, const Styler& styler, const Evaluator& evaluator,
                          const stylist::Options& options);

// Performers that already move in a style: from every style to every other, with the input style
// not given to the network and given; if given, also to neutral. A row per input style, a column
// per target.
nlohmann::json JudgeStyledInputs(const Data& data, const Styler& styler, const Evaluator& evaluator,
                                 const stylist::Options& options);

// Clips of other rigs, which no judge was trained on. Per clip, the worst over styles of the jerk
// (120 Hz, output over input) and of the largest rotation of one joint between two frames; and
// whether the performer's acts are kept (acts.h), mean over styles. Their first seconds are
// added to `scenes`, for the report. Errors name the file.
Result<nlohmann::json> JudgeOtherClips(std::span<const std::filesystem::path> files,
                                       const Styler& styler, const stylist::Options& options,
                                       std::vector<Scene>& scenes);

}  // namespace styled::judge
