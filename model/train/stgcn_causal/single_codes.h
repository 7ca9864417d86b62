#pragma once

#include <torch/torch.h>

#include <cstdint>
#include <vector>

#include "model/net/style_space.h"
#include "model/train/dataset.h"

namespace styled::train::st_gcn_causal {

// Codes of single examples and noises, [styles, n, code], for a student that should follow them and
// not only the styles' means. Half of each style's codes are of noises, the seeds 1, 2, ..., and
// half of windows of its clips drawn by `seed`: by turns with the head of the style and with that
// without a label, as live examples are read. A style without clips has noises only. `styles`: for
// each style of the clips, that of `space`.
torch::Tensor SingleCodes(const net::StyleSpace& space, const std::vector<TrainingClip>& clips,
                          const std::vector<int64_t>& styles, int n, uint64_t seed);

}  // namespace styled::train::st_gcn_causal
