#pragma once

#include <torch/torch.h>

#include <string>
#include <vector>

#include "model/clip/manifest.h"
#include "model/train/dataset.h"
#include "model/train/erd/networks.h"
#include "model/train/recipe.h"

namespace styled::train::style_erd {

// A cheap check of a run's progress, on fixed windows of neutral validation clips, in the published
// (detail-preserving) form, over the contents in which a style was recorded. Not the evaluation:
// styleeval judges published poses. Figures: reconstruction_deg, the mean angle per joint between
// reconstruction and input; then per style expression (the shift of the mean pose along the real
// one's, 1 if they are equal), cosine (between the two shifts) and jerk_ratio (mean joint jerk over
// the input's). One thread.
class Monitor {
 public:
  // Needs neutral clips of at least 49 frames in every content; other contents are left out.
  Monitor(const std::vector<TrainingClip>& clips, const std::vector<clip::ManifestStyle>& styles,
          int contents, const erd::FeatureParameters& parameters, const torch::Tensor& mean,
          const torch::Tensor& deviation);

  MonitorReport Evaluate(const Generator& generator) const;

 private:
  static constexpr int kFrames = 48;
  static constexpr int kSkipped = 8;  // frames that the states need to settle
  static constexpr int kWindowsPerContent = 6;

  // The measurements of a transfer to one style, or of the reconstruction.
  struct Sequences {
    torch::Tensor z_neutral, z_residual, one_hot, rec, input;
    torch::Tensor positions;  // of the input, without the skipped frames
  };

  void AddWindows(const std::vector<TrainingClip>& clips, int contents,
                  const erd::FeatureParameters& parameters, std::vector<int64_t>& kept);
  Sequences Run(const Generator& generator) const;
  torch::Tensor StyledPositions(const Generator& generator, const Sequences& run,
                                int64_t style) const;

  std::vector<std::string> names_;  // of the styles but neutral
  torch::Tensor features_;          // [kFrames, B, 211]
  torch::Tensor u_;                 // standardized
  torch::Tensor labels_;            // [B, contents] one-hot
  torch::Tensor content_;           // [contents, B]: mean over a content's windows
  torch::Tensor real_shift_;        // [styles, contents, 63]: real neutral -> real style
  torch::Tensor present_;           // [styles, contents, 1]: 1 where the style was recorded
};

}  // namespace styled::train::style_erd
