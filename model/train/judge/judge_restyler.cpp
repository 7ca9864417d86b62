#include "model/train/judge/judge_restyler.h"

#include "model/clip/clip.h"

namespace styled::judge {

std::vector<Transferred> Restyle(const Data& data, const Restyler& restyler,
                                 const std::function<Target(int input, int style)>& target) {
  std::vector<Transferred> out;
  for (std::size_t i = 0; i < data.inputs.size(); ++i) {
    const int input = static_cast<int>(i);
    const Poses thin = Thin(data.inputs[i]);
    for (int style = 1; style < static_cast<int>(data.manifest.styles.size()); ++style) {
      if (!restyler.Has(style)) continue;
      Poses output = clip::ResamplePoses(restyler.Restyle(thin, target(input, style)),
                                         kJudgeRate_hz, kStreamRate_hz);
      output.resize(data.inputs[i].size(), output.back());  // the last period may be missing
      out.push_back({input, style, data.contents[i], data.inputs[i], std::move(output)});
    }
  }
  return out;
}

}  // namespace styled::judge
