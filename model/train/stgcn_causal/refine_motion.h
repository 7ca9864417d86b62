#pragma once

#include <torch/torch.h>

#include <vector>

#include "model/train/stgcn/windows.h"

namespace styled::train::st_gcn_causal {

// Clips as standardized features, [frames, 21, 7] each.
using Frames = std::vector<torch::Tensor>;
Frames FramesOf(const std::vector<std::vector<body::Pose>>& clips,
                const st_gcn::Statistics& statistics, const stgcn::FeatureParameters& parameters);
Frames Mirrored(const Frames& clips);

// Each clip's beginning, and its last `share`, which is kept apart for figures.
struct Parts {
  Frames first, last;
};
Parts Split(const Frames& clips, double share);

// Windows of `frames`, [B, frames, 21, 7], of clips and places drawn by `random`, all equally
// probable. A shorter clip has its first frame repeated before it, as live.
torch::Tensor DrawWindows(const Frames& clips, int64_t frames, int64_t count,
                          std::mt19937_64& random);

// Of a set of frames: mean and deviation of each feature, [21, 7], and the deviation of its
// difference from frame to frame.
struct Moments {
  torch::Tensor mean, deviation, change;
};
Moments MomentsOf(const torch::Tensor& windows);  // [B, T, 21, 7]
Moments MomentsOf(const Frames& clips);

// Mean distances of joints, cm: between mean poses, and between how far joints move about them
// (deviations by axis).
double MeanDistance_cm(const Moments& a, const Moments& b, const torch::Tensor& deviation);
double SpreadDistance_cm(const Moments& a, const Moments& b, const torch::Tensor& deviation);

}  // namespace styled::train::st_gcn_causal
