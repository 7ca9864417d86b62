#include "model/train/stgcn_causal/single_codes.h"

#include <algorithm>
#include <random>
#include <span>

#include "model/train/stgcn/networks.h"

namespace styled::train::st_gcn_causal {
namespace {

net::StyleSource NoiseOf(int style, int seed) {
  return {.style = style, .seed = static_cast<std::uint64_t>(seed), .reference = {}, .weight = 1};
}

// A window of a clip of the style; the whole clip if it is shorter.
std::span<const body::Pose> Draw(const std::vector<const TrainingClip*>& clips,
                                 std::mt19937_64& random) {
  const auto& poses = clips[random() % clips.size()]->poses;
  const std::size_t length =
      std::min(poses.size(), static_cast<std::size_t>(st_gcn::kWindowFrames));
  return {poses.data() + random() % (poses.size() - length + 1), length};
}

}  // namespace

torch::Tensor SingleCodes(const net::StyleSpace& space, const std::vector<TrainingClip>& clips,
                          const std::vector<int64_t>& styles, int n, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<torch::Tensor> codes(styles.size());
  for (std::size_t own = 0; own < styles.size(); ++own) {
    const auto style = static_cast<int>(styles[own]);
    std::vector<const TrainingClip*> of_style;
    for (const TrainingClip& clip : clips) {
      if (clip.style == static_cast<int>(own) && !clip.poses.empty()) of_style.push_back(&clip);
    }
    std::vector<torch::Tensor> rows;
    for (int i = 0; i < n; ++i) {
      net::StyleSource source = NoiseOf(style, i / 2 + 1);
      if (i % 2 == 1 && !of_style.empty()) {
        const bool labelled = i % 4 == 1;
        source = {.style = labelled ? style : -1, .seed = {}, .reference = Draw(of_style, random)};
      }
      const net::StyleCode code = space.MakeCode({.sources = {source}});
      rows.push_back(torch::tensor(code));
    }
    codes[static_cast<std::size_t>(style)] = torch::stack(rows);
  }
  return torch::stack(codes);
}

}  // namespace styled::train::st_gcn_causal
