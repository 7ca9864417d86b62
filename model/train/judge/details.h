#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "model/train/judge/acts.h"
#include "model/train/judge/data.h"
#include "model/train/judge/gait.h"
#include "model/train/judge/metrics.h"

namespace styled::judge {

// Details of styled clips that the judges' shares do not show: walking and running compared with
// the input and the real style, the calmness of each clip, and whether its acts are kept.
struct StyleDetails {
  std::vector<Gait> gait_output, gait_real;  // by gait, as Details::gaits
  JerkRatios jerk;
  ActsKept acts;
};
struct Details {
  std::string title;
  std::vector<std::string> gaits;    // the contents walk and run, of those that the manifest has
  std::vector<Gait> gait_input;      // by gait
  std::vector<StyleDetails> styles;  // by manifest style; [0] is empty
  JerkRatios jerk;                   // over all styles
  ActsKept acts;
};

// `clips` are of `data`'s inputs. The real style is that of every clip that `data` has, because
// there are too few judged ones (a single elderly walk in bandai-2).
Details MeasureDetails(const Data& data, std::string title, std::span<const Transferred> clips);

// Tables with a row per style; "-" if nothing was measured. In JSON that is null.
void Print(const clip::Manifest& manifest, const Details& details);
nlohmann::json ToJson(const clip::Manifest& manifest, const Details& details);
nlohmann::json ToJson(const ActsKept& acts);

}  // namespace styled::judge
