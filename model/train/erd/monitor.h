#pragma once

#include <torch/torch.h>

#include <string>
#include <vector>

#include "model/train/dataset.h"
#include "model/train/erd/networks.h"

namespace styled::train {

// A cheap look at how a run learns, on fixed windows of neutral validation clips, in the published
// (detail-preserving) form, over the contents in which a style was recorded. Not the evaluation:
// styleeval judges published poses.
struct MonitorRow {
  double reconstruction_deg = 0;   // mean angle per joint between rec and input
  std::vector<double> expression;  // per style: shift of the mean pose along the real one's
  std::vector<double> cosine;      // per style: between the two shifts
  std::vector<double> jerk_ratio;  // per style: mean joint jerk over the input's
};

class Monitor {
 public:
  // Needs neutral clips of at least 49 frames in every content; other contents are left out.
  Monitor(const std::vector<TrainingClip>& clips, int styles, int contents,
          const erd::FeatureParameters& parameters, const torch::Tensor& mean,
          const torch::Tensor& deviation);

  MonitorRow Evaluate(const Generator& generator) const;

 private:
  static constexpr int kFrames = 48;
  static constexpr int kSkipped = 8;  // frames that the states need to settle
  static constexpr int kWindowsPerContent = 6;

  int styles_;
  torch::Tensor features_;    // [kFrames, B, 211]
  torch::Tensor u_;           // standardized
  torch::Tensor content_;     // [contents, B]: mean over a content's windows
  torch::Tensor real_shift_;  // [styles, contents, 63]: real neutral -> real style
  torch::Tensor present_;     // [styles, contents, 1]: 1 where the style was recorded
};

}  // namespace styled::train
