#pragma once

#include <torch/torch.h>

#include <vector>

#include "model/train/dataset.h"

namespace styled::train::style_erd {

// The mean effect of each style on a body, per style and content: how far it shifts every joint,
// and how much wider or narrower it moves it (the deviation over time within a window). Measured
// between neutral and styled clips of one folder, mirror images included, and averaged over
// folders: recordings of two folders under one name are not compared. 147 shifts, then 147
// deviations; of each the first 84 are of local rotations (which show how hands are held and limbs
// are twisted, which no position shows), times kRotationLever_m; 63 are of positions in the heading
// frame, relative to the hips, in metres.
inline constexpr int64_t kEffectFeatures = erd::kRotationFeatures + erd::kPositionFeatures;
inline constexpr double kRotationLever_m = 0.3;  // what makes half an angle a length
struct StyleEffects {
  torch::Tensor moments;  // [styles, contents, 294]
  torch::Tensor known;    // [styles, contents, 1]: 1 where a folder has both
};
// From windows of `length` frames, half overlapping; a cell with fewer than `fewest` is not known.
StyleEffects MeasureEffects(const std::vector<TrainingClip>& clips, int styles, int contents,
                            int length, int fewest, const erd::FeatureParameters& parameters);

// Draws the effects of the generator's output toward those of real clips. The critic sees one
// window at a time and is satisfied before the means agree. After the feature matching of Salimans
// et al. 2016, here on the pose itself, with running means instead of the batch's.
class Moments {
 public:
  Moments(const StyleEffects& wanted, const torch::Device& device);

  // One value whose gradient moves the running means of `out` - `in` (features r and p, [T, B,
  // 147]) toward the target moments. Only windows with `counted` 1 take part. style, content: [B]
  // int64.
  torch::Tensor Loss(const torch::Tensor& in, const torch::Tensor& out, const torch::Tensor& style,
                     const torch::Tensor& content, const torch::Tensor& counted);

  // Mean over cells with data of the squared distance from the target moments, summed over joints;
  // a scalar on the device.
  torch::Tensor Distance() const;

  torch::Tensor Save() const;  // the running means
  void Restore(const torch::Tensor& saved);

 private:
  int64_t contents_;
  torch::Tensor wanted_;   // [styles * contents, 294]
  torch::Tensor known_;    // [styles * contents, 1]: 1 where there are clips to compare
  torch::Tensor running_;  // [styles * contents, 294]
  torch::Tensor visits_;   // [styles * contents, 1]
};

}  // namespace styled::train::style_erd
